#include <benchmark/benchmark.h>

#include "engine/core/parallel.h"

int main(int argc, char** argv) {
    whorl::wait_passively(argv);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
}
