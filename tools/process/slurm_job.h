#pragma once
/// Jobs of Slurm.
#include <string>

namespace whorl {

/// The number of the job that sbatch made. @param said what `sbatch --parsable` wrote: the number, in some places with the cluster's name
/// ("7;north"), among notices of the place's own @return "" where it made none
std::string slurm_job(const std::string& said);

/// Whether one of the jobs ("7,8") waits or is at work. Not where there is no Slurm, or none that knows them any more.
bool slurm_jobs_live(const std::string& jobs);

}  // namespace whorl
