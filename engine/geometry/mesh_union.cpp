#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/core/errors.h"
#include "engine/geometry/mesh_file.h"
#include "engine/geometry/mesh_shape.h"
#include "engine/geometry/vessel.h"

namespace whorl {
namespace {

constexpr double no_distance = std::numeric_limits<double>::infinity();

/// Closed parts that may overlap, touch or contain each other. The solid is the union of the parts, but a part inside another is a hollow
/// in that part.
class Parts final : public Shape {
public:
    Parts(const std::vector<TriangleMesh>& meshes, std::vector<std::string> notes) {
        std::vector<Part> parts;
        std::ptrdiff_t crossings = 0;
        for (const TriangleMesh& mesh : meshes) {
            parts.push_back({std::make_shared<MeshShape>(mesh), bulk_of(mesh).volume});
            crossings += parts.back().mesh->crossings(), overlap_ |= parts.back().mesh->crosses_much();
        }
        if (crossings > 0)
            notes.push_back(fmt::format(
                "the mesh intersects itself, with {} faces inside it; the inside is where the winding number is not 0", crossings));
        remarks = std::move(notes);
        std::vector<std::size_t> from_left(parts.size());
        std::iota(from_left.begin(), from_left.end(), 0u);
        std::vector<std::size_t> by_volume = from_left;
        const auto box = [&](std::size_t k) -> const Eigen::AlignedBox3d& { return parts[k].mesh->box(); };
        std::stable_sort(from_left.begin(), from_left.end(), [&](auto i, auto j) { return box(i).min().x() < box(j).min().x(); });
        std::stable_sort(by_volume.begin(), by_volume.end(), [&](auto i, auto j) { return parts[i].volume > parts[j].volume; });
        std::vector<std::vector<std::size_t>> near(parts.size());
        for (std::size_t i = 0; i < parts.size(); ++i)
            for (std::size_t j = i + 1; j < parts.size(); ++j) {
                const std::size_t a = from_left[i], b = from_left[j];
                if (box(b).min().x() > box(a).max().x()) break;
                if (box(a).intersects(box(b))) near[a].push_back(b), near[b].push_back(a);
            }
        for (const std::size_t k : by_volume)
            for (const std::size_t other : near[k]) {
                if (parts[other].volume < parts[k].volume) continue;
                if (parts[other].volume > parts[k].volume && within(meshes[k], *parts[other].mesh))
                    parts[k].depth = std::max(parts[k].depth, parts[other].depth + 1);
                else overlap_ = overlap_ || (box(k).intersection(box(other)).sizes().array() > 0).all();
            }
        // Parts that are near no other are merged into one mesh, because there the nearest face determines the sign.
        TriangleMesh alone;
        for (std::size_t k = 0; k < parts.size(); ++k) {
            if (near[k].empty()) append(alone, meshes[k]);
            else parts_.push_back(parts[k]);
        }
        if (!alone.triangle.empty()) parts_.push_back({std::make_shared<MeshShape>(std::move(alone))});
        std::stable_sort(parts_.begin(), parts_.end(), [](const Part& p, const Part& q) { return p.depth < q.depth; });
    }

    Real distance(const Vec3& x) const override {
        std::size_t whose = 0;
        return Real(distance(x.cast<double>(), whose));
    }
    Vec3 normal(const Vec3& x) const override {
        std::size_t whose = 0;
        distance(x.cast<double>(), whose);
        return parts_[whose].sign() * parts_[whose].mesh->normal(x);
    }
    void bounds(Vec3& min, Vec3& max) const override {
        const Eigen::AlignedBox3d box = whole_box();
        min = box.min().cast<Real>(), max = box.max().cast<Real>();
    }
    /// If parts overlap, integrates over evenly spread points (Roberts's sequence), because a sum over the surfaces would count overlaps
    /// twice.
    MassProperties bulk() const override {
        if (!overlap_) return Shape::bulk();
        const Eigen::AlignedBox3d box = whole_box();
        const Vec3d apart(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
        const int count = std::clamp(20'000'000 / static_cast<int>(parts_.size()), 20'000, 200'000);  // each point queries every part
        const double share = box.volume() / count;
        MassProperties bulk;
        Vec3d first = Vec3d::Zero();
        for (int n = 1; n <= count; ++n) {
            const Vec3d turns = n * apart, r = box.sizes().cwiseProduct(turns - Vec3d(turns.array().floor()));
            bool inside = false;
            for (const Part& part : parts_)
                if (part.mesh->holds(box.min() + r)) inside = !part.hollow();
            if (!inside) continue;
            bulk.volume += share, first += share * r, bulk.moment += share * r * r.transpose();
        }
        if (!(bulk.volume > 0)) return {};
        const Vec3d centre = first / bulk.volume;
        bulk.moment -= bulk.volume * centre * centre.transpose();
        bulk.centre = box.min() + centre;
        return bulk;
    }
    TriangleMesh mesh(Real edge, Real extent) const override {
        TriangleMesh all;
        for (const Part& part : parts_) {
            TriangleMesh one = part.mesh->mesh(edge, extent);
            if (part.hollow()) {
                for (Vec3f& n : one.normal) n = -n;
                for (auto& t : one.triangle) std::swap(t[1], t[2]);
            }
            append(all, one);
        }
        return all;
    }

private:
    struct Part {
        std::shared_ptr<const MeshShape> mesh;
        double volume = 0;
        int depth = 0;  ///< number of parts that enclose this part
        bool hollow() const { return depth % 2 == 1; }
        Real sign() const { return hollow() ? Real(-1) : Real(1); }
    };

    /// Whether `inner` lies in `outer`. Of the corners and middles of inner's triangles, none must be outside and at least one must be
    /// inside; the surfaces may touch.
    static bool within(const TriangleMesh& inner, const MeshShape& outer) {
        const double rounding = 1e-6 * outer.box().min().cwiseAbs().cwiseMax(outer.box().max().cwiseAbs()).norm();
        bool inside = false;
        for (const auto& t : inner.triangle) {
            const Vec3d a = inner.position[t[0]].cast<double>(), b = inner.position[t[1]].cast<double>(),
                        c = inner.position[t[2]].cast<double>();
            for (const Vec3d& x : {a, b, c, Vec3d((a + b + c) / 3)}) {
                const double distance = outer.distance(x, no_distance);
                if (distance > rounding) return false;
                inside = inside || distance < -rounding;
            }
        }
        return inside;
    }

    /// Signed distance to the union of the solid parts minus the hollows. @param whose index of the nearest part
    double distance(const Vec3d& x, std::size_t& whose) const {
        double best = no_distance;
        for (std::size_t k = 0; k < parts_.size(); ++k) {
            const Part& part = parts_[k];
            const double sign = part.sign(), gap = std::sqrt(part.mesh->box().squaredExteriorDistance(x));
            if (gap > 0 && gap >= sign * best) continue;
            const double one = sign * part.mesh->distance(x, gap > 0 ? sign * best : no_distance);
            if (part.hollow() ? one > best : one < best) best = one, whose = k;
        }
        return best;
    }
    Eigen::AlignedBox3d whole_box() const {
        Eigen::AlignedBox3d box;
        for (const Part& part : parts_) box.extend(part.mesh->box());
        return box;
    }

    std::vector<Part> parts_;  ///< sorted by depth: enclosing parts come before the parts in them
    bool overlap_ = false;
};

}  // namespace

std::shared_ptr<const Shape> make_mesh(TriangleMesh mesh, const std::string& name) {
    std::vector<std::string> remarks;
    const std::size_t read = mesh.triangle.size();
    weld(mesh);
    if (mesh.triangle.empty()) throw InputError({name}, "the mesh contains no triangles");
    if (const std::size_t lost = read - mesh.triangle.size()) remarks.push_back(fmt::format("faces without an area left out: {}", lost));
    const std::vector<TriangleMesh> parts = closed_parts(std::move(mesh), name, remarks);
    if (parts.size() == 1)
        if (const auto one = std::make_shared<MeshShape>(parts[0]); one->crossings() == 0) {
            one->remarks = std::move(remarks);
            return one;
        }
    return std::make_shared<Parts>(parts, std::move(remarks));
}

std::shared_ptr<const Shape> make_sheet(TriangleMesh surface) { return std::make_shared<MeshShape>(std::move(surface)); }

std::shared_ptr<const Shape> make_mesh(const std::filesystem::path& file, double scale, const Vec3d& position, const std::string& node) {
    return make_mesh(read_mesh(file, scale, position, node), file.string());
}

}  // namespace whorl
