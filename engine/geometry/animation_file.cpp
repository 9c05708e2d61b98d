#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tiny_gltf.h>

#include <Eigen/LU>
#include <algorithm>
#include <cstring>
#include <numbers>

#include "engine/core/errors.h"
#include "engine/core/smooth_keys.h"
#include "engine/geometry/motion.h"
#include "engine/geometry/rigid_body.h"

namespace whorl {

using Vec4d = Eigen::Vector4d;

struct AnimationFile::Content {
    std::string file;
    tinygltf::Model model;
    std::vector<int> parent;  ///< of each node; -1: none
};

namespace {

/// Keys of a translation (x, y, z, 0) or a rotation (quaternion x, y, z, w). Empty: at rest.
struct NodeTrack {
    std::vector<double> time;
    std::vector<Vec4d> value, in, out;  ///< in and out: tangents of CUBICSPLINE [1/s]; otherwise empty

    bool changes() const {
        return std::any_of(value.begin(), value.end(), [&](const Vec4d& v) { return v != value[0]; }) ||
               std::any_of(out.begin(), out.end(), [](const Vec4d& v) { return !v.isZero(0); });
    }
    /// The segment that contains t, and its part before t (0 to 1). Outside of the keys its length is 0.
    struct Part {
        std::size_t from, to;
        double s, length;
    };
    Part at(double t) const {
        if (t < time.front() || time.size() == 1) return {0, 0, 0, 0};
        if (t >= time.back()) return {time.size() - 1, time.size() - 1, 0, 0};
        const auto to = static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), t) - time.begin());
        const double length = time[to] - time[to - 1];
        return {to - 1, to, (t - time[to - 1]) / length, length};
    }
    CubicPoint<Vec4d> cubic(const Part& p) const {
        const auto [x, slope] = hermite<Vec4d>(value[p.from], value[p.to], p.length * out[p.from], p.length * in[p.to], p.s);
        return {x, slope / p.length};
    }
};

/// A node relative to its parent.
struct Joint {
    MotionState rest;
    NodeTrack translation, rotation;

    void translate(double t, MotionState& state) const {
        const NodeTrack::Part p = translation.at(t);
        state.position = translation.value[p.from].head<3>();
        if (p.length <= 0) return;
        const Vec4d step = translation.value[p.to] - translation.value[p.from];
        const auto [x, rate] =
            translation.out.empty() ? CubicPoint<Vec4d>{translation.value[p.from] + p.s * step, step / p.length} : translation.cubic(p);
        state.position = x.head<3>(), state.velocity = rate.head<3>();
    }
    void rotate(double t, MotionState& state) const {
        const NodeTrack::Part p = rotation.at(t);
        const Eigen::Quaterniond from(rotation.value[p.from]);
        state.turn = from;
        if (p.length <= 0) return;
        if (!rotation.out.empty()) {  // q = c/|c|, spin = 2 q* dq/dt
            const auto [c, rate] = rotation.cubic(p);
            const double length = c.norm();
            const Vec4d q = c / length, dq = (rate - q * q.dot(rate)) / length;
            state.turn.coeffs() = q;
            state.spin = 2 * (state.turn.conjugate() * Eigen::Quaterniond(dq)).vec();
            return;
        }
        Eigen::Quaterniond step = from.conjugate() * Eigen::Quaterniond(rotation.value[p.to]);
        if (step.w() < 0) step.coeffs() *= -1;  // the shorter way
        const Eigen::AngleAxisd angle(step.normalized());
        state.spin = angle.angle() / p.length * angle.axis();
        state.turn = from * Eigen::Quaterniond(turn_by(p.s * p.length * state.spin));
    }
    MotionState at(double t) const {
        MotionState state = rest;
        if (!translation.time.empty()) translate(t, state);
        if (!rotation.time.empty()) rotate(t, state);
        return state;
    }
};

/// A node's axes in the scene. @param joints from the root to the node
MotionState composed(const std::vector<Joint>& joints, double t) {
    MotionState whole;
    for (const Joint& joint : joints) {
        const MotionState own = joint.at(t);
        whole.velocity += whole.turn * (whole.spin.cross(own.position) + own.velocity);
        whole.position += whole.turn * own.position;
        whole.spin = own.turn.conjugate() * whole.spin + own.spin;
        whole.turn = (whole.turn * own.turn).normalized();
    }
    return whole;
}

/// Reads the joints of one node.
class JointReader {
public:
    JointReader(const std::string& file, const tinygltf::Model& model) : file_(file), model_(model) {}

    Joint read(int node, const std::string& name) {
        name_ = name;
        Joint joint;
        const tinygltf::Node& n = model_.nodes[static_cast<std::size_t>(node)];
        if (n.translation.size() == 3) joint.rest.position = Vec3d(n.translation.data());
        if (n.rotation.size() == 4) joint.rest.turn = Eigen::Quaterniond(n.rotation.data());
        if (n.scale.size() == 3) check_scale(Vec3d(n.scale.data()));
        if (n.matrix.size() == 16) {
            const Eigen::Matrix4d matrix(n.matrix.data());
            const Mat3d M = matrix.topLeftCorner<3, 3>();
            check_scale(M.determinant() < 0 ? Vec3d(-1, 1, 1) : Vec3d(M.colwise().norm()));
            if (!(M.transpose() * M).isIdentity(1e-3)) fail("is sheared", apply_);
            joint.rest.position = matrix.topRightCorner<3, 1>(), joint.rest.turn = Eigen::Quaterniond(M);
        }
        if (!(joint.rest.turn.norm() > 0.5)) fail("has an invalid rotation");
        joint.rest.turn.normalize();
        for (const tinygltf::Animation& animation : model_.animations)
            for (const tinygltf::AnimationChannel& channel : animation.channels)
                if (channel.target_node == node) add(animation, channel, joint);
        return joint;
    }

private:
    static constexpr const char* apply_ = "apply its scale (in Blender: Object > Apply > Scale)";

    [[noreturn]] void fail(const std::string& what, const std::string& hint = "") const {
        throw InputError({file_}, fmt::format("{} {}", name_, what), hint);
    }
    void check_scale(const Vec3d& scale) const {
        if ((scale - Vec3d::Ones()).cwiseAbs().maxCoeff() <= 1e-4) return;
        if (scale.prod() < 0) fail("is mirrored", apply_);
        fail(fmt::format("is scaled by [{:.4g}, {:.4g}, {:.4g}]", scale.x(), scale.y(), scale.z()), apply_);
    }
    void add(const tinygltf::Animation& animation, const tinygltf::AnimationChannel& channel, Joint& joint) {
        const bool turns = channel.target_path == "rotation", scales = channel.target_path == "scale";
        if (!turns && !scales && channel.target_path != "translation") return;
        if (channel.sampler < 0 || channel.sampler >= static_cast<int>(animation.samplers.size())) fail("has an animation without keys");
        const NodeTrack track = keys(animation.samplers[static_cast<std::size_t>(channel.sampler)], turns ? 4 : 3);
        if (scales) {
            for (const Vec4d& v : track.value) check_scale(v.head<3>());
            return;
        }
        NodeTrack& mine = turns ? joint.rotation : joint.translation;
        if (!mine.time.empty()) fail(fmt::format("has two animations of its {}", channel.target_path), "keep one of them in the file");
        mine = track;
        for (Vec4d& v : mine.value) {
            if (!turns) continue;
            if (!(v.norm() > 0.5)) fail("has an invalid rotation in a key");
            v.normalize();
        }
    }
    NodeTrack keys(const tinygltf::AnimationSampler& sampler, int width) const {
        NodeTrack track;
        const bool cubic = sampler.interpolation == "CUBICSPLINE";
        const std::vector<double> times = numbers(sampler.input, 1), all = numbers(sampler.output, width);
        const std::size_t each = (cubic ? 3 : 1) * static_cast<std::size_t>(width);
        if (times.empty() || all.size() != times.size() * each) fail("has a damaged animation: it has as many values as times");
        track.time = times;
        for (std::size_t k = 0; k < all.size(); k += static_cast<std::size_t>(width)) {
            Vec4d v = Vec4d::Zero();
            std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(k), width, v.data());
            if (!v.allFinite()) fail("has an animation with a number that is not finite");
            (!cubic                                           ? track.value
             : k % each == 0                                  ? track.in
             : k % each < 2 * static_cast<std::size_t>(width) ? track.value
                                                              : track.out)
                .push_back(v);
        }
        for (std::size_t k = 0; k < times.size(); ++k)
            if (!std::isfinite(times[k]) || (k > 0 && !(times[k] > times[k - 1]))) fail("has an animation whose times do not increase");
        if (!cubic && sampler.interpolation != "LINEAR" && track.changes())
            fail(fmt::format("jumps from key to key (interpolation {})", sampler.interpolation),
                 "use LINEAR or CUBICSPLINE (in Blender: linear or Bezier keyframes)");
        return track;
    }
    /// The floats of an accessor with `width` of them per entry.
    std::vector<double> numbers(int index, int width) const {
        const auto& m = model_;
        const auto within = [](int i, const auto& list) { return i >= 0 && i < static_cast<int>(list.size()); };
        if (!within(index, m.accessors)) fail("has a damaged animation: a list of numbers is missing");
        const tinygltf::Accessor& a = m.accessors[static_cast<std::size_t>(index)];
        if (a.sparse.isSparse || !within(a.bufferView, m.bufferViews))
            fail("has an animation in a sparse accessor, which is not supported");
        const tinygltf::BufferView& view = m.bufferViews[static_cast<std::size_t>(a.bufferView)];
        if (a.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
            fail("has an animation with numbers other than floats, which are not supported");
        const int stride = a.ByteStride(view);
        if (!within(view.buffer, m.buffers) || stride <= 0 || tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type)) != width)
            fail("has a damaged animation: a list of numbers has another type");
        const std::vector<unsigned char>& bytes = m.buffers[static_cast<std::size_t>(view.buffer)].data;
        std::vector<float> row(static_cast<std::size_t>(width));
        const std::size_t size = 4 * row.size(), step = static_cast<std::size_t>(stride), begin = view.byteOffset + a.byteOffset;
        const bool ends = std::max({view.byteOffset, a.byteOffset, begin + size}) > bytes.size();
        if (a.count > 0 && (ends || (bytes.size() - begin - size) / step < a.count - 1))
            fail("has a damaged animation: the file ends before its last key");
        std::vector<double> all;
        for (std::size_t k = 0; k < a.count; ++k) {
            std::memcpy(row.data(), bytes.data() + begin + k * step, size);
            all.insert(all.end(), row.begin(), row.end());
        }
        return all;
    }

    const std::string& file_;
    const tinygltf::Model& model_;
    std::string name_;
};

}  // namespace

AnimationFile::AnimationFile(const std::filesystem::path& file) {
    auto content = std::make_shared<Content>();
    content->file = file.filename().string();
    const std::string kind = file.extension().string();
    if (kind != ".glb" && kind != ".gltf")
        throw InputError({file.string()}, "\"" + kind + "\" is not a kind of animation file", "", "allowed: .gltf, .glb");
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(
        [](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) { return true; }, nullptr);
    std::string error, warning;
    tinygltf::Model& m = content->model;
    const bool read = kind == ".glb" ? loader.LoadBinaryFromFile(&m, &error, &warning, file.string())
                                     : loader.LoadASCIIFromFile(&m, &error, &warning, file.string());
    if (!read) throw InputError({file.string()}, "it is not a valid glTF 2.0 file: " + error.substr(0, error.find('\n')));
    content->parent.assign(m.nodes.size(), -1);
    for (std::size_t k = 0; k < m.nodes.size(); ++k)
        for (const int child : m.nodes[k].children)
            if (child >= 0 && child < static_cast<int>(m.nodes.size()))
                content->parent[static_cast<std::size_t>(child)] = static_cast<int>(k);
    content_ = std::move(content);
}

AnimationFile::Node AnimationFile::node(const std::string& name) const {
    const tinygltf::Model& m = content_->model;
    std::vector<std::string> names;
    int found = -1;
    for (std::size_t k = 0; k < m.nodes.size(); ++k) {
        if (m.nodes[k].name == name && found >= 0)
            throw InputError({content_->file}, fmt::format("{} has two nodes \"{}\"", content_->file, name), "rename one of them");
        if (m.nodes[k].name == name) found = static_cast<int>(k);
        if (!m.nodes[k].name.empty() && names.size() < 40) names.push_back(m.nodes[k].name);
    }
    if (found < 0) {
        const std::string near = nearest_name(name, names);
        throw InputError({content_->file}, fmt::format("{} has no node \"{}\"", content_->file, name),
                         near.empty() ? "" : "did you mean \"" + near + "\"?", fmt::format("allowed: {}", fmt::join(names, ", ")));
    }
    Node node;
    auto joints = std::make_shared<std::vector<Joint>>();
    JointReader reader(content_->file, m);
    for (int k = found; k >= 0 && joints->size() <= m.nodes.size(); k = content_->parent[static_cast<std::size_t>(k)]) {
        const std::string& own = m.nodes[static_cast<std::size_t>(k)].name;
        joints->push_back(
            reader.read(k, k == found ? fmt::format("node \"{}\"", own) : fmt::format("\"{}\", a parent of \"{}\",", own, name)));
        node.motion.turns |= joints->back().rotation.changes();
        node.motion.moves |= joints->back().translation.changes();
    }
    std::reverse(joints->begin(), joints->end());
    node.motion.moves |= node.motion.turns && joints->size() > 1;
    node.motion.at = [joints = std::shared_ptr<const std::vector<Joint>>(joints)](double t) { return composed(*joints, t); };
    const int camera = m.nodes[static_cast<std::size_t>(found)].camera;
    if (camera >= 0 && camera < static_cast<int>(m.cameras.size()) && m.cameras[static_cast<std::size_t>(camera)].type == "perspective")
        node.fov = 180 / std::numbers::pi * m.cameras[static_cast<std::size_t>(camera)].perspective.yfov;
    return node;
}

}  // namespace whorl
