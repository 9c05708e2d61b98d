#include "tools/cost/coarse_run.h"

#include <fmt/format.h>

#include "engine/io/snapshot.h"
#include "engine/scene/frame_times.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

template <class T>
void repeat_each(std::vector<T>& values, std::size_t times) {
    std::vector<T> all;
    all.reserve(times * values.size());
    for (const T& value : values) all.insert(all.end(), times, value);
    values = std::move(all);
}

}  // namespace

bool run_coarsely(const SceneFile& file, double coarser, int moments, const std::vector<std::string>& fields,
                  const std::function<void(const Frame&, const Simulation&)>& show, const std::function<void(double)>& progress) try {
    const std::string spacing = fmt::format("fluid.spacing={:.9g}", coarser * file.scene.fluid.spacing);
    const SceneFile coarse = changed(file, {read_change(parse_change(spacing))});
    Replay replay(coarse);
    Simulation simulation(coarse.scene, make_plan(coarse.scene));
    const Snapshots snapshots(simulation, fields);
    const double first = frame_time(file.scene, 1), last = frame_time(file.scene, frame_count(file.scene));
    show(snapshots.take(simulation, 1), simulation);
    for (int k = 1; k <= moments; ++k) {
        const double time = first + k * (last - first) / moments;
        while (simulation.time() < time) {
            if (simulation.step(time).diverged) return false;
            replay.apply_until(simulation.time(), [&](const Scene& s, const Plan& p, double when) { simulation.change(s, p, when); });
            progress((simulation.time() - first) / (last - first));
        }
        show(snapshots.take(simulation, 1), simulation);
    }
    return true;
} catch (const InputError&) { return false; }

Frame parted(const Frame& coarse, int coarser) {
    Frame frame = coarse;
    frame.spacing /= static_cast<float>(coarser);
    std::vector<Vec3f> offsets;
    const float first = -0.5f * static_cast<float>(coarser - 1);
    const int layers = frame.dimensions == 3 ? coarser : 1;
    for (int i = 0; i < coarser; ++i)
        for (int j = 0; j < coarser; ++j)
            for (int k = 0; k < layers; ++k)
                offsets.push_back(frame.spacing * Vec3f(first + static_cast<float>(i), first + static_cast<float>(j),
                                                        layers > 1 ? first + static_cast<float>(k) : 0));
    repeat_each(frame.position, offsets.size());
    for (std::size_t i = 0; i < frame.position.size(); ++i) {
        Vec3f& x = frame.position[i];
        x += offsets[i % offsets.size()];
        for (int a = 0; a < frame.dimensions; ++a) {
            const float length = frame.domain_max[a] - frame.domain_min[a];
            if (frame.periodic[a]) x[a] += x[a] < frame.domain_min[a] ? length : x[a] >= frame.domain_max[a] ? -length : 0;
        }
    }
    repeat_each(frame.velocity, offsets.size());
    for (auto& [name, values] : frame.scalar) repeat_each(values, offsets.size());
    for (auto& [name, values] : frame.vector) repeat_each(values, offsets.size());
    for (auto& [name, values] : frame.whole) repeat_each(values, offsets.size());
    return frame;
}

}  // namespace whorl
