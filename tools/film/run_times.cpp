#include "tools/film/run_times.h"

namespace whorl {

RunTimes::RunTimes() : began_(wall_seconds()), cpu_before_(process_cpu_seconds()) {}

void RunTimes::add_earlier(const Checkpoint& checkpoint) {
    earlier_wall_ = checkpoint.wall, earlier_cpu_ = checkpoint.cpu;
    earlier_stages_ = checkpoint.stages;
    resumed_ = checkpoint.resumed + 1;
}

double RunTimes::wall() const { return earlier_wall_ + wall_seconds() - began_; }
double RunTimes::cpu() const { return earlier_cpu_ + process_cpu_seconds() - cpu_before_; }

StageTimes RunTimes::stages(const StageTimes& simulation, const StageTimes& film) const {
    StageTimes all = with_shared_cpu(simulation, simulation_cpu_);
    StageTimes of_film = film;
    all.merge(of_film);
    for (const auto& [name, t] : earlier_stages_) {
        StageTime& sum = all[name];
        sum.wall += t.wall, sum.cpu += t.cpu, sum.calls += t.calls;
    }
    return all;
}

StageTimes with_shared_cpu(StageTimes stages, double simulation_cpu) {
    double wall = 0;
    for (const auto& [name, t] : stages) wall += t.wall;
    for (auto& [name, t] : stages) t.cpu = wall > 0 ? simulation_cpu * t.wall / wall : 0;
    return stages;
}

}  // namespace whorl
