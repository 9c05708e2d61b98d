#include "tools/process/slurm_job.h"

#include <sstream>
#include <system_error>

#include "render/video/process.h"

namespace whorl {

std::string slurm_job(const std::string& said) {
    std::istringstream in(said);
    for (std::string line; std::getline(in, line);) {
        const std::string number = line.substr(0, line.find(';'));
        if (!number.empty() && number.find_first_not_of("0123456789") == std::string::npos) return number;
    }
    return {};
}

bool slurm_jobs_live(const std::string& jobs) try {
    ChildProcess squeue({"squeue", "--noheader", "--jobs=" + jobs, "--format=%i"});
    return squeue.wait() == 0 && squeue.output().find_first_not_of('\n') != std::string::npos;
} catch (const std::system_error&) { return false; }

}  // namespace whorl
