#include "tools/process/slurm_job.h"

#include <sstream>

namespace whorl {

std::string slurm_job(const std::string& said) {
    std::istringstream in(said);
    for (std::string line; std::getline(in, line);) {
        const std::string number = line.substr(0, line.find(';'));
        if (!number.empty() && number.find_first_not_of("0123456789") == std::string::npos) return number;
    }
    return {};
}

}  // namespace whorl
