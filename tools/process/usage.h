#pragma once
/// What a run uses of the machine.
#include <cstdint>
#include <map>
#include <string>

namespace whorl {

/// Gives the calling thread a name. Threads that it starts from then on (OpenMP's, TBB's) inherit it, so that their CPU time counts with
/// it.
void name_thread(const char* name);
/// CPU seconds so far of the threads that live, by thread name. Mesa's own ("llvmpipe-0", ...) count as "draw".
std::map<std::string, double> cpu_by_thread_name();
/// CPU seconds of the child processes that have ended (the encoder).
double children_cpu_seconds();
/// CPU seconds so far: of the program with the encoders it ran; and of its threads but those that make pictures ("surface", "draw",
/// "export", "write").
double process_cpu_seconds();
double simulation_cpu_seconds();
/// The process's largest resident memory so far [bytes].
std::uint64_t peak_memory();
/// The process's resident memory now [bytes].
std::uint64_t resident_memory();
/// "AMD EPYC ...", and the machine's memory [bytes].
std::string processor_name();
std::uint64_t total_memory();

}  // namespace whorl
