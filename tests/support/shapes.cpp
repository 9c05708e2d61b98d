#include "tests/support/shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace whorl::test {

float interpolated(const Volume& v, const Vec3f& x) {
    const Vec3f u = (x - v.origin) / v.voxel;
    const int i = std::clamp(static_cast<int>(u.x()), 0, v.nx - 2), j = std::clamp(static_cast<int>(u.y()), 0, v.ny - 2),
              k = std::clamp(static_cast<int>(u.z()), 0, v.nz - 2);
    const Vec3f f = u - Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
    float sum = 0;
    for (int c = 0; c < 8; ++c) {
        const int a = c & 1, b = (c >> 1) & 1, d = c >> 2;
        const float weight = (a ? f.x() : 1 - f.x()) * (b ? f.y() : 1 - f.y()) * (d ? f.z() : 1 - f.z());
        sum += weight * v.value[v.index(i + a, j + b, k + d)];
    }
    return sum;
}

namespace {

constexpr float pi_f = std::numbers::pi_v<float>;

/// Marching tetrahedra: each cube falls into six tetrahedra about its main diagonal; vertices on shared edges are shared.
class TetrahedraMesher {
public:
    explicit TetrahedraMesher(const Volume& volume) : volume_(volume) {}

    TriangleMesh mesh() {
        constexpr int paths[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
        for (int k = 0; k + 1 < volume_.nz; ++k)
            for (int j = 0; j + 1 < volume_.ny; ++j)
                for (int i = 0; i + 1 < volume_.nx; ++i)
                    for (const auto& path : paths) {
                        std::array<std::uint64_t, 4> corner{};
                        for (int c = 0; c < 4; ++c) corner[c] = index(i + (path[c] & 1), j + ((path[c] >> 1) & 1), k + (path[c] >> 2));
                        tetrahedron(corner);
                    }
        for (const Vec3f& x : mesh_.position) {
            const float h = volume_.voxel;
            Vec3f gradient;
            for (int a = 0; a < 3; ++a)
                gradient[a] = interpolated(volume_, x + h * Vec3f::Unit(a)) - interpolated(volume_, x - h * Vec3f::Unit(a));
            mesh_.normal.push_back(gradient.normalized());
        }
        return std::move(mesh_);
    }

private:
    std::uint64_t index(int i, int j, int k) const { return (static_cast<std::uint64_t>(k) * volume_.ny + j) * volume_.nx + i; }
    Vec3f place(std::uint64_t n) const {
        const auto i = n % volume_.nx, j = n / volume_.nx % volume_.ny, k = n / volume_.nx / volume_.ny;
        return volume_.origin + volume_.voxel * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
    }

    std::uint32_t vertex(std::uint64_t a, std::uint64_t b) {
        if (a > b) std::swap(a, b);
        const auto [found, is_new] = edges_.try_emplace(a << 32 | b, static_cast<std::uint32_t>(mesh_.position.size()));
        if (is_new) {
            const float s = volume_.value[a] / (volume_.value[a] - volume_.value[b]);
            mesh_.position.push_back(place(a) + s * (place(b) - place(a)));
        }
        return found->second;
    }

    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Vec3f& outward) {
        const Vec3f normal = (mesh_.position[b] - mesh_.position[a]).cross(mesh_.position[c] - mesh_.position[a]);
        if (normal.dot(outward) < 0) std::swap(b, c);
        mesh_.triangle.push_back({a, b, c});
    }

    void tetrahedron(const std::array<std::uint64_t, 4>& corner) {
        std::vector<std::uint64_t> in, out;
        Vec3f middle_in = Vec3f::Zero(), middle_out = Vec3f::Zero();
        for (const auto c : corner) {
            const bool inside = volume_.value[c] < 0;
            (inside ? in : out).push_back(c);
            (inside ? middle_in : middle_out) += place(c);
        }
        if (in.empty() || out.empty()) return;
        const Vec3f outward = middle_out / static_cast<float>(out.size()) - middle_in / static_cast<float>(in.size());
        if (in.size() == 2) {
            const auto a = vertex(in[0], out[0]), b = vertex(in[0], out[1]), c = vertex(in[1], out[1]), d = vertex(in[1], out[0]);
            triangle(a, b, c, outward);
            triangle(a, c, d, outward);
        } else {
            const auto& alone = in.size() == 1 ? in : out;
            const auto& rest = in.size() == 1 ? out : in;
            triangle(vertex(alone[0], rest[0]), vertex(alone[0], rest[1]), vertex(alone[0], rest[2]), outward);
        }
    }

    const Volume& volume_;
    TriangleMesh mesh_;
    std::unordered_map<std::uint64_t, std::uint32_t> edges_;
};

/// Soft union of radius r: threads that touch flow together.
float joined(float a, float b, float r) {
    const float h = std::max(r - std::abs(a - b), 0.0f) / r;
    return std::min(a, b) - 0.25f * h * h * r;
}

float to_segment(const Vec3f& x, const Vec3f& a, const Vec3f& b, float& along) {
    along = std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0f, 1.0f);
    return (x - a - along * (b - a)).norm();
}

}  // namespace

Surface surface_of(const ShapeDistance& distance, const Vec3f& low, const Vec3f& high, float voxel) {
    constexpr float band = 3;  // voxels, as narrow as a level set's
    Surface surface;
    Volume& v = surface.distance;
    v.voxel = voxel;
    v.origin = low - Vec3f::Constant(4 * voxel);
    const Vec3f size = high - low;
    v.nx = static_cast<int>(size.x() / voxel) + 9;
    v.ny = static_cast<int>(size.y() / voxel) + 9;
    v.nz = static_cast<int>(size.z() / voxel) + 9;
    for (int k = 0; k < v.nz; ++k)
        for (int j = 0; j < v.ny; ++j)
            for (int i = 0; i < v.nx; ++i) {
                const Vec3f x = v.origin + voxel * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
                v.value.push_back(std::clamp(distance(x), -band * voxel, band * voxel));
            }
    surface.mesh = TetrahedraMesher(v).mesh();
    return surface;
}

Surface coiled_thread(float radius, float coil, int turns, float height, float voxel) {
    // The thread's axis as a chain of segments: a helix that settles layer on layer, wider below, then up to the nozzle.
    std::vector<Vec3f> axis;
    std::vector<float> thickness;
    const int steps_a_turn = 40, steps = steps_a_turn * turns;
    for (int n = 0; n <= steps; ++n) {
        const float s = static_cast<float>(n) / static_cast<float>(steps), angle = 2 * pi_f * static_cast<float>(n) / steps_a_turn;
        const float wide = coil * (1.25f - 0.5f * s) * (1 + 0.06f * std::sin(1.7f * angle));
        axis.emplace_back(wide * std::cos(angle), 0.8f * radius + 1.55f * radius * static_cast<float>(turns) * s, wide * std::sin(angle));
        thickness.push_back(radius * (1.12f - 0.12f * s));
    }
    const Vec3f top = axis.back(), along(-std::sin(0.0f), 0.35f, 1);
    for (int n = 1; n <= 24; ++n) {
        const float s = static_cast<float>(n) / 24;
        const Vec3f bend = top + coil * 0.9f * s * (1 - s) * along.normalized();
        const Vec3f end(0, height, 0);
        axis.push_back((1 - s * s) * bend + s * s * (end + (1 - s) * Vec3f(0, -0.4f * height, 0)));
        thickness.push_back(radius * (0.95f + 0.25f * s * s));
    }
    const auto distance = [&](const Vec3f& x) {
        std::size_t first = 0;
        const auto nearest = [&](bool elsewhere) {  // distance to the turns without `first`
            float least = 1;
            for (std::size_t n = 0; n + 1 < axis.size(); ++n) {
                if (std::abs(x.y() - axis[n].y()) > 6 * radius || (elsewhere && std::max(n, first) - std::min(n, first) < 16)) continue;
                float s = 0;
                const float d = to_segment(x, axis[n], axis[n + 1], s) - ((1 - s) * thickness[n] + s * thickness[n + 1]);
                if (d < least) {
                    least = d;
                    if (!elsewhere) first = n;
                }
            }
            return least;
        };
        const float own = nearest(false), thread = joined(own, nearest(true), 0.4f * radius);
        const float puddle = (x.cwiseProduct(Vec3f(1, 3.2f, 1)).norm() - 1.75f * coil) / 2;
        return std::max(joined(thread, puddle, radius), -0.4f * radius - x.y());  // extends slightly into the ground, as a level set does
    };
    const float wide = 1.9f * coil + 2 * radius;
    return surface_of(distance, Vec3f(-wide, -0.4f * radius, -wide), Vec3f(wide, height, wide), voxel);
}

Surface sphere(const Vec3f& centre, float radius, float voxel) {
    return surface_of([&](const Vec3f& x) { return (x - centre).norm() - radius; }, centre - Vec3f::Constant(radius),
                      centre + Vec3f::Constant(radius), voxel);
}

Surface pool(float half_width, float depth, float voxel) {
    const auto distance = [&](const Vec3f& x) {
        const float r = std::hypot(x.x(), x.z()) / half_width;
        const float level =
            depth * (1 + 0.8f * std::exp(-14 * r * r) + 0.12f * std::sin(9 * x.x() / half_width) * std::cos(7 * x.z() / half_width));
        const float side = std::max(std::abs(x.x()), std::abs(x.z())) - half_width;
        return std::max({0.8f * (x.y() - level), side, -0.1f * depth - x.y()});
    };
    return surface_of(distance, Vec3f(-half_width, -0.1f * depth, -half_width), Vec3f(half_width, 2 * depth, half_width), voxel);
}

std::vector<Vec3f> lattice(int nx, int ny, int nz, float d) {
    std::vector<Vec3f> x;
    for (int i = 0; i < nx; ++i)
        for (int j = 0; j < ny; ++j)
            for (int k = 0; k < nz; ++k) x.push_back(d * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)));
    return x;
}

FrameSolid solid_of(TriangleMesh mesh, const std::string& material, bool container) {
    FrameSolid solid;
    solid.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
    solid.appearance.material = material, solid.container = container;
    return solid;
}

TriangleMesh box_mesh(const Vec3f& low, const Vec3f& high) {
    TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            const Vec3f normal = side * Vec3f::Unit(axis);
            const Vec3f u = Vec3f::Unit((axis + 1) % 3), v = normal.cross(u);
            const auto first = static_cast<std::uint32_t>(mesh.position.size());
            for (const auto& [a, b] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
                const Vec3f unit = normal + a * u + b * v;
                mesh.position.push_back(0.5f * (low + high) + 0.5f * unit.cwiseProduct(high - low));
                mesh.normal.push_back(normal);
            }
            mesh.triangle.push_back({first, first + 1, first + 2});
            mesh.triangle.push_back({first, first + 2, first + 3});
        }
    return mesh;
}

TriangleMesh cylinder_mesh(const Vec3f& base, float radius, float height) {
    TriangleMesh mesh;
    constexpr std::uint32_t sides = 96;
    const auto ring = [&](float y, const Vec3f& normal, float r) {
        for (std::uint32_t i = 0; i < sides; ++i) {
            const float angle = 2 * pi_f * static_cast<float>(i) / sides;
            const Vec3f out(std::cos(angle), 0, std::sin(angle));
            mesh.position.push_back(base + r * out + Vec3f(0, y, 0));
            mesh.normal.push_back(normal.isZero() ? out : normal);
        }
    };
    ring(0, Vec3f::Zero(), radius), ring(height, Vec3f::Zero(), radius);
    ring(0, -Vec3f::UnitY(), radius), ring(height, Vec3f::UnitY(), radius);
    for (std::uint32_t i = 0; i < sides; ++i) {
        const std::uint32_t n = (i + 1) % sides;
        mesh.triangle.push_back({i, sides + i, sides + n});
        mesh.triangle.push_back({i, sides + n, n});
        if (i >= 1 && i + 1 < sides) {
            mesh.triangle.push_back({2 * sides, 2 * sides + i, 2 * sides + n});
            mesh.triangle.push_back({3 * sides, 3 * sides + n, 3 * sides + i});
        }
    }
    return mesh;
}

std::vector<FrameSolid> chequered_board(float tile) {
    std::vector<FrameSolid> board;
    for (const int white : {0, 1}) {
        TriangleMesh tiles;
        for (int i = -10; i < 10; ++i)
            for (int k = -10; k < 10; ++k) {
                if (((i + k) & 1) != white) continue;
                const float x = tile * static_cast<float>(i), z = tile * static_cast<float>(k);
                const TriangleMesh one = box_mesh(Vec3f(x, -0.01f, z), Vec3f(x + tile, 0, z + tile));
                const auto first = static_cast<std::uint32_t>(tiles.position.size());
                tiles.position.insert(tiles.position.end(), one.position.begin(), one.position.end());
                tiles.normal.insert(tiles.normal.end(), one.normal.begin(), one.normal.end());
                for (const auto& t : one.triangle) tiles.triangle.push_back({first + t[0], first + t[1], first + t[2]});
            }
        board.push_back(solid_of(std::move(tiles), white != 0 ? "white" : "dark"));
    }
    return board;
}

}  // namespace whorl::test
