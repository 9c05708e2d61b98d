#include "render/gl/glass_solids.h"

#include <algorithm>
#include <cmath>

#include "render/gl/setup.h"
#include "render/look/material.h"

namespace whorl {
namespace {

constexpr std::size_t most_glasses = 48, most_glass_planes = 320;  // as in solids_of_glass.glsl
constexpr float polished = 0.05f;                                  // roughness up to which the surface of glass is smooth

bool same_glass(const FrameSolid& a, const FrameSolid& b) {
    const SolidMaterial p = solid_material(a.appearance), q = solid_material(b.appearance);
    return p.refraction == q.refraction && p.absorption == q.absorption;
}

bool overlap(const Bounds& a, const Bounds& b) {
    const Vec3f near = Vec3f::Constant(0.02f * std::max(a.radius(), b.radius()));
    return ((a.low - near).array() < b.high.array()).all() && ((b.low - near).array() < a.high.array()).all();
}

/// The bounds of the mesh as a body.
ConvexBody box_of(const TriangleMesh& mesh) {
    const Bounds bounds = bounds_of(mesh.position);
    ConvexBody box;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3f n = Vec3f::Unit(axis);
        box.planes.emplace_back(n.x(), n.y(), n.z(), -bounds.high[axis]);
        box.planes.emplace_back(-n.x(), -n.y(), -n.z(), bounds.low[axis]);
    }
    return box;
}

}  // namespace

void GlassSolids::fill(const std::vector<FrameSolid>& solids) {
    std::erase_if(known_, [&](const auto& entry) {
        return std::none_of(solids.begin(), solids.end(), [&](const FrameSolid& solid) { return solid.mesh == entry.first; });
    });
    std::vector<Entry> entries;
    for (const FrameSolid& solid : solids) {
        const auto [place, is_new] = known_.try_emplace(solid.mesh);
        if (is_new) place->second = {exact_solid(*solid.mesh), static_cast<float>(volume_of(*solid.mesh))};
        entries.push_back({&solid, &place->second, entries.size(), -1});
    }
    std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.known->volume < b.known->volume; });
    choose_channels(entries);
    number_.resize(entries.size());
    for (std::size_t k = 0; k < entries.size(); ++k) number_[entries[k].place] = static_cast<int>(std::min(k, most_glasses - 1));
    std::vector<const FrameSolid*> in_field;
    std::vector<int> channel;
    for (const Entry& entry : entries)
        if (entry.channel >= 0) in_field.push_back(entry.solid), channel.push_back(entry.channel);
    field_.fill(in_field, channel, channels_);
    add_looks(entries);
}

/// Puts solids that are not exact, or too many, into channels of the field. Different glasses that may touch have different channels.
void GlassSolids::choose_channels(std::vector<Entry>& entries) {
    std::size_t planes = 0;
    int most = -1;
    first_ = Eigen::Vector4f::Constant(1e6f);
    for (std::size_t k = 0; k < entries.size(); ++k) {
        Entry& entry = entries[k];
        const auto& exact = entry.known->exact;
        planes += exact ? exact->outer.planes.size() + exact->cavity.planes.size() : 6;
        if (exact && k + 1 < most_glasses && planes + 6 * (most_glasses - k) < most_glass_planes) continue;
        entry.channel = 0;
        for (std::size_t l = 0; l < k; ++l)
            if (entries[l].channel >= entry.channel && !same_glass(*entry.solid, *entries[l].solid) &&
                overlap(bounds_of(*entry.solid), bounds_of(*entries[l].solid)))
                entry.channel = std::min(entries[l].channel + 1, 3);
        most = std::max(most, entry.channel);
        first_[entry.channel] = std::min(first_[entry.channel], static_cast<float>(k));
    }
    channels_ = most < 0 ? 0 : most == 0 ? 1 : 4;
}

void GlassSolids::add_body(const ConvexBody& body) {
    const auto first = static_cast<float>(planes_.size());
    planes_.insert(planes_.end(), body.planes.begin(), body.planes.end());
    const auto round = body.round ? static_cast<float>(rounds_.size()) : -1.0f;
    if (body.round) {
        rounds_.emplace_back(body.round->centre.x(), body.round->centre.y(), body.round->centre.z(), body.round->radius);
        rounds_.emplace_back(body.round->axis.x(), body.round->axis.y(), body.round->axis.z(), 0.0f);
    }
    bodies_.emplace_back(first, static_cast<float>(planes_.size()), round, body.empty() ? 0.0f : 1.0f);
}

void GlassSolids::add_looks(const std::vector<Entry>& entries) {
    planes_.clear(), rounds_.clear(), bodies_.clear(), looks_.clear();
    for (std::size_t k = 0; k < std::min(entries.size(), most_glasses); ++k) {
        const Entry& entry = entries[k];
        const ExactSolid shape = entry.channel < 0 ? *entry.known->exact : ExactSolid{box_of(*entry.solid->mesh), {}};
        const ExactSolid placed = moved(shape, entry.solid->rotation, entry.solid->translation);
        add_body(placed.outer), add_body(placed.cavity);
        const SolidMaterial material = solid_material(entry.solid->appearance);
        looks_.emplace_back(material.absorption.x(), material.absorption.y(), material.absorption.z(), material.refraction);
        looks_.emplace_back(std::max(material.roughness - polished, 0.0f), static_cast<float>(entry.channel), 0.0f, 0.0f);
    }
}

std::string GlassSolids::constants() const { return gl::constant("glass_channels", channels_); }

void GlassSolids::bind(gl::Program& program, int unit) const {
    field_.bind(program, unit);
    if (channels_ == 0) program.set("glass_voxel", 0.0f);
    program.set("glasses", static_cast<int>(looks_.size() / 2));
    program.set("glass_plane", planes_);
    program.set("glass_round", rounds_);
    program.set("glass_body", bodies_);
    program.set("glass_look", looks_);
    program.set("glass_first", first_);
}

}  // namespace whorl
