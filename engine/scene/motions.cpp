#include "engine/scene/motions.h"

#include <fmt/format.h>

#include <filesystem>

#include "engine/core/smooth_keys.h"

namespace whorl {
namespace {

/// The function f in the place of `replaced`, with the text of that.
VectorExpression expression_of(const std::function<Vec3d(double t)>& f, const VectorExpression& replaced) {
    VectorExpression all;
    for (std::size_t a = 0; a < 3; ++a)
        all.component[a] = Expression([f, a](double t) { return f(t)[static_cast<Eigen::Index>(a)]; }, replaced.component[a].text());
    return all;
}

class Motions {
public:
    Motions(const Scene& scene, Reader& reader) : scene_(scene), reader_(reader) {}

    void solid(const std::string& name, SolidKeys& s) {
        Motion motion = node_of(name, s);
        if (times_differ(name, s.keys)) motion = motion_of(s.keys);
        if (!motion.at) return;
        if (s.density > 0)
            reader_.disagree({name + ".density"}, name + " has a density, so forces move it, but it has keys or an animation",
                             "remove one of them, and give its position and velocity at the start");
        if (!s.rotation.is_zero() || !s.tilt.isZero(0))
            reader_.disagree({name + (s.tilt.isZero(0) ? ".rotation" : ".tilt")}, name + " is turned by its keys or its animation",
                             "remove rotation and tilt; keys have their own tilt");
        if (!s.animation.empty()) {
            if (s.pivot && !s.pivot->isZero(0))
                reader_.disagree({name + ".pivot"}, name + ".pivot: with an animation the solid turns about the origin of its node",
                                 "remove pivot");
            s.pivot = Vec3d::Zero();
        }
        s.motion = motion.at;
        s.position = expression_of([at = motion.at, own = s.position](double t) { return Vec3d(own(t) + at(t).position); }, s.position);
        if (motion.turns) s.rotation = expression_of([at = motion.at](double t) { return at(t).spin; }, s.rotation);
    }

    void emitter(const std::string& name, EmitterKeys& e) {
        const auto add = [&](const std::function<Vec3d(double)>& f) {
            e.position = expression_of([f, own = e.position](double t) { return Vec3d(own(t) + f(t)); }, e.position);
        };
        if (const Motion motion = node_of(name, e); motion.at) {
            add([at = motion.at](double t) { return at(t).position; });
            if (motion.turns || e.direction.depends_on_time() || !motion.at(0).turn.isApprox(Eigen::Quaterniond::Identity(), 0))
                e.direction =
                    expression_of([at = motion.at, own = e.direction](double t) { return Vec3d(at(t).turn * own(t)); }, e.direction);
        } else if (times_differ(name, e.keys)) {
            const auto keys = std::make_shared<std::vector<EmitterKey>>(by_time(e.keys));
            const auto between = [keys](double t, auto&& vector) {
                Vec3d v;
                for (int a = 0; a < 3; ++a) v[a] = smooth_between(*keys, t, [&](const EmitterKey& key) { return vector(key)[a]; }).value;
                return v;
            };
            add([between](double t) { return between(t, [](const EmitterKey& key) { return key.position; }); });
            bool turns = false;
            for (EmitterKey& key : *keys) {
                turns |= key.direction.has_value();
                if (!key.direction) key.direction = e.direction(key.time);
            }
            if (turns)
                e.direction = expression_of(
                    [between](double t) { return between(t, [](const EmitterKey& key) { return *key.direction; }); }, e.direction);
        } else if (e.keys.empty() && e.animation.empty() && reader_.places.count(name + ".position") == 0) {
            reader_.disagree({name + ".position", name}, name + ".position is missing", "middle of the opening [m]");
        }
    }

private:
    /// Whether there are keys with different times. Reports equal times.
    template <class Key>
    bool times_differ(const std::string& name, const std::vector<Key>& keys) {
        for (std::size_t k = 0; k < keys.size(); ++k)
            for (std::size_t j = 0; j < k; ++j)
                if (keys[j].time == keys[k].time) {
                    reader_.disagree({entry_name(name + ".key", k) + ".time"},
                                     fmt::format("{0}.key[{1}] and {0}.key[{2}] are both at {3:g} s", name, k, j, keys[k].time),
                                     "only the camera may jump; use another time");
                    return false;
                }
        return !keys.empty();
    }

    /// The motion of the node that a solid or emitter follows; empty if there is none, or if it is faulty.
    template <class Entry>
    Motion node_of(const std::string& name, const Entry& entry) {
        const std::string file = name + ".animation", node = name + ".node";
        if (entry.animation.empty()) {
            if (!entry.node.empty()) reader_.disagree({node}, node + " needs an animation", "set animation to the glTF file of this node");
            return {};
        }
        if (entry.node.empty()) reader_.disagree({file}, node + " is missing", "set node to the name of a node of the file");
        if (!entry.keys.empty()) reader_.disagree({file}, name + " has keys and an animation", "remove one of them");
        if (scene_.domain.dimensions == 2)
            reader_.disagree({file}, file + " needs three dimensions (domain.dimensions is 2)",
                             "use [[" + name.substr(0, name.find('[')) + ".key]]");
        if (entry.node.empty() || !std::filesystem::is_regular_file(entry.animation)) return {};
        std::string key = file;
        try {
            const AnimationFile read(entry.animation);
            key = node;
            const Motion motion = read.node(entry.node).motion;
            if (motion.moves || motion.turns) return motion;
            reader_.disagree({node}, node + fmt::format(": no animation moves the node \"{}\" or its parents", entry.node),
                             "choose an animated node, or use position and tilt");
        } catch (const InputError& e) {
            for (const Problem& p : e.problems()) reader_.disagree({key}, key + ": " + p.what, p.hint, p.allowed);
        }
        return {};
    }

    const Scene& scene_;
    Reader& reader_;
};

}  // namespace

void add_motions(Scene& scene, Reader& reader) {
    Motions motions(scene, reader);
    for (std::size_t i = 0; i < scene.solids.size(); ++i) motions.solid(entry_name("solid", i), scene.solids[i]);
    for (std::size_t i = 0; i < scene.emitters.size(); ++i) motions.emitter(entry_name("emitter", i), scene.emitters[i]);
}

}  // namespace whorl
