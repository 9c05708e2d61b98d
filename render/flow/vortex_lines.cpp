#include "render/flow/vortex_lines.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "engine/core/parallel.h"
#include "render/flow/cloud.h"

namespace whorl {
namespace {

constexpr float weak = 0.1f;  ///< strength below which a line ends
constexpr int around = 8;     ///< corners of a cross-section

struct LinePoint {
    Vec3f position, tangent, side, colour;
    float strength = 0, light = 1;
};

/// Data for tracing a line.
struct LineField {
    const FlowGrid& grid;
    std::vector<float> depth;  ///< optical depth between each node and the lamp
    float spacing;

    /// Sets the position, tangent, strength and colour of a point. @return false if the field is too weak for a line, or there is no fluid
    bool sample(const Vec3f& x, LinePoint& point) const {
        const FlowGrid::Sample s = grid.at(x);
        const float turn = s.along.norm();
        if (s.cover < 0.4f || turn <= 0 || s.value[3] < weak) return false;
        point.position = x, point.tangent = s.along / turn;
        point.strength = s.value[3], point.colour = s.value.head<3>() / s.value[3];
        return true;
    }
    float light(const Vec3f& x) const {
        const FlowGrid::Corners near = grid.corners(x);
        float sum = 0;
        for (int c = 0; c < 8; ++c) sum += near.weight[c] * depth[near.node[c]];
        return std::exp(-sum);
    }
    /// Side of a ribbon after a step [m]. It follows the neighbouring line in the direction `side`, which winds about this one.
    Vec3f turned(const LinePoint& p, const Vec3f& side, float step) const {
        const float offset = 0.5f * spacing;
        const Vec3f here = grid.at(p.position - offset * side).along, there = grid.at(p.position + offset * side).along;
        const float turn = 0.5f * (here + there).norm();
        return turn > 0 ? Vec3f(side + step * (there - here) / (2 * offset * turn)) : side;
    }
};

/// Component of `side` normal to the tangent, as a unit vector; any normal if `side` is along the tangent.
Vec3f across(const Vec3f& side, const Vec3f& tangent) {
    const Vec3f square = side - side.dot(tangent) * tangent;
    const float length = square.norm();
    return length > 1e-4f ? Vec3f(square / length) : Vec3f(tangent.unitOrthogonal());
}

/// Points of a line to one side of its seed, without the seed. @param step negative: backwards [m] @param most largest number of points
/// @param closed set to true if the line returns to the seed
std::vector<LinePoint> walk(const LineField& field, const LinePoint& seed, float step, int most, bool& closed) {
    std::vector<LinePoint> line;
    LinePoint at = seed, half;
    for (int k = 0; k < most; ++k) {
        if (!field.sample(at.position + 0.5f * step * at.tangent, half)) break;
        LinePoint next;
        if (!field.sample(at.position + step * half.tangent, next)) break;
        line.push_back(next);
        at = next;
        if (k > 8 && (at.position - seed.position).norm() < 0.7f * std::abs(step)) {
            closed = true;
            break;
        }
    }
    return line;
}

constexpr float most_steps = 20000;  // to each side of a seed

std::vector<LinePoint> line_through(const LineField& field, const LinePoint& seed, const LineShape& shape) {
    const float step = 0.5f * field.spacing;
    const int most = std::max(1, static_cast<int>(std::min(shape.length / step, most_steps)));
    bool closed = false;
    std::vector<LinePoint> ahead = walk(field, seed, step, most, closed), line;
    if (!closed) {
        line = walk(field, seed, -step, most, closed);
        std::reverse(line.begin(), line.end());
    }
    line.push_back(seed);
    const std::size_t middle = line.size() - 1;
    line.insert(line.end(), ahead.begin(), ahead.end());
    // The side is carried from the seed to both ends. At the seed it starts from a constant vector, so that it does not jump between
    // frames.
    line[middle].side = across(Vec3f(0.3f, 1, 0.2f), line[middle].tangent);
    const auto carry = [&](std::size_t from, std::size_t to, float way) {
        const Vec3f side = shape.flat ? field.turned(line[from], line[from].side, way) : line[from].side;
        line[to].side = across(side, line[to].tangent);
    };
    for (std::size_t k = middle; k + 1 < line.size(); ++k) carry(k, k + 1, step);
    for (std::size_t k = middle; k > 0; --k) carry(k, k - 1, -step);
    for (LinePoint& p : line) p.light = field.light(p.position);
    // Ends are thin. The strength at the seed scales the whole line, so that a line does not appear suddenly at full width.
    const auto fade = [](float x) { return std::clamp(x, 0.0f, 1.0f); };
    const float whole = fade((seed.strength - weak) / weak);
    const int taper = std::max(1, most / 5);
    for (std::size_t k = 0; k < line.size(); ++k) {
        const auto end = static_cast<float>(std::min(k, line.size() - 1 - k)) / static_cast<float>(taper);
        line[k].strength = whole * fade(2 * (line[k].strength - weak)) * (closed ? 1 : fade(end));
    }
    if (closed) line.push_back(line[middle == 0 ? 0 : middle]);
    return line;
}

/// Vector [m] of whole periods by which a point lies outside the periodic domain.
Vec3f periods_outside(const Frame& frame, const Vec3f& x) {
    Vec3f shift = Vec3f::Zero();
    for (int a = 0; a < 3; ++a) {
        const float length = frame.domain_max[a] - frame.domain_min[a];
        if (frame.periodic[a]) shift[a] = length * std::floor((x[a] - frame.domain_min[a]) / length);
    }
    return shift;
}

/// Adds the triangles of lines to a mesh.
class LineMesher {
public:
    LineMesher(VortexLines& all, const LineShape& shape) : all_(all), shape_(shape) {}

    /// Adds points first .. last - 1 of a line, which are in one period. A lid closes an end unless the line is very thin there.
    void piece(const std::vector<LinePoint>& line, std::size_t first, std::size_t last, const Vec3f& shift) {
        if (last - first < 2) return;
        lid(line[first], shift, -1);
        for (std::size_t k = first; k < last; ++k) {
            ring(line[k], shift);
            if (k == first) continue;
            const auto now = static_cast<std::uint32_t>(all_.position.size()) - around, before = now - around;
            for (std::uint32_t c = 0; c < around; ++c) {
                const std::uint32_t next = (c + 1) % around;
                for (const std::uint32_t corner : {before + c, now + c, before + next, before + next, now + c, now + next})
                    all_.index.push_back(corner);
            }
        }
        lid(line[last - 1], shift, 1);
    }

private:
    void ring(const LinePoint& p, const Vec3f& shift) {
        const float half = 0.5f * shape_.width * p.strength, wide = shape_.flat ? 2.5f * half : half,
                    thick = shape_.flat ? 0.3f * half : half;
        const Vec3f up = p.tangent.cross(p.side);
        for (int c = 0; c < around; ++c) {
            const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(c) / around, x = std::cos(angle), y = std::sin(angle);
            // The ellipse's normal, times its half-widths: (x thick, y wide).
            const Vec3f normal = shape_.flat ? Vec3f(0.12f * x * p.side + y * up) : Vec3f(x * p.side + y * up);
            add(p.position - shift + wide * x * p.side + thick * y * up, normal.normalized(), p);
        }
    }
    void lid(const LinePoint& p, const Vec3f& shift, float way) {
        if (p.strength < 0.05f) return;
        const auto first = static_cast<std::uint32_t>(all_.position.size());
        ring(p, shift);
        for (std::uint32_t c = 0; c < around; ++c) all_.normal[first + c] = way * p.tangent;
        for (std::uint32_t c = 1; c + 1 < around; ++c)
            for (const std::uint32_t corner : {first, first + c, first + c + 1}) all_.index.push_back(corner);
    }
    void add(const Vec3f& position, const Vec3f& normal, const LinePoint& p) {
        all_.position.push_back(position), all_.normal.push_back(normal), all_.colour.push_back(p.colour), all_.light.push_back(p.light);
    }
    VortexLines& all_;
    const LineShape& shape_;
};

/// Particles that lines pass through.
std::vector<std::size_t> seeds_of(const Frame& frame, int count) {
    std::vector<std::size_t> chosen(frame.position.size());
    std::iota(chosen.begin(), chosen.end(), std::size_t{0});
    const auto grain = frame.scalar.find("grain");
    const std::size_t few = std::min(chosen.size(), static_cast<std::size_t>(std::max(count, 0)));
    if (grain != frame.scalar.end() && few < chosen.size())
        std::nth_element(chosen.begin(), chosen.begin() + static_cast<std::ptrdiff_t>(few), chosen.end(),
                         [&](std::size_t a, std::size_t b) { return std::pair(grain->second[a], a) < std::pair(grain->second[b], b); });
    chosen.resize(few);
    return chosen;
}

}  // namespace

VortexLines vortex_lines(const Frame& frame, const FlowGrid& grid, const LineShape& shape) {
    VortexLines all;
    if (grid.empty()) return all;
    const LineField field{grid, depth_towards(grid, cloud_density(grid), shape.thickness, shape.lamp), frame.spacing};
    const std::vector<std::size_t> seeds = seeds_of(frame, shape.seeds);
    std::vector<std::vector<LinePoint>> lines(seeds.size());
    parallel_for(static_cast<Index>(seeds.size()), [&](Index s) {
        LinePoint seed;
        if (field.sample(frame.position[seeds[s]], seed)) lines[s] = line_through(field, seed, shape);
    });
    LineMesher mesher(all, shape);
    for (const std::vector<LinePoint>& line : lines)
        for (std::size_t first = 0; first < line.size();) {
            const Vec3f shift = periods_outside(frame, line[first].position);
            std::size_t last = first + 1;
            while (last < line.size() && periods_outside(frame, line[last].position) == shift) ++last;
            mesher.piece(line, first, last, shift);
            first = last;
        }
    return all;
}

namespace {

constexpr int pieces = 6;  ///< number of steps of a trail

}  // namespace

Trails trails(const Frame& frame, const std::vector<Vec3f>& colour, const FlowGrid& grid, float seconds, float width, const Vec3f& eye) {
    constexpr std::size_t corners = 2 * (pieces + 1), indices = 6 * pieces;
    const std::size_t n = frame.position.size();
    Trails all;
    all.position.resize(corners * n);
    all.colour.resize(corners * n);
    all.index.resize(indices * n);
    const float step = seconds / pieces;
    parallel_for(static_cast<Index>(n), [&](Index p) {
        Vec3f way[pieces + 1];
        way[0] = frame.position[p];
        for (int k = 0; k < pieces; ++k) {
            const Vec3f first = k == 0 ? frame.velocity[p] : grid.at(way[k]).along;
            way[k + 1] = way[k] - step * grid.at(way[k] - 0.5f * step * first).along;
        }
        for (int k = 0; k <= pieces; ++k) {
            const Vec3f along = way[std::max(0, k - 1)] - way[std::min(pieces, k + 1)];
            Vec3f side = along.cross(way[k] - eye);
            const float length = side.norm();
            side = length > 0 ? Vec3f(side / length) : Vec3f(Vec3f::Zero());
            const float half = 0.5f * width * (1 - static_cast<float>(k) / pieces);
            const std::size_t corner = corners * p + 2 * k;
            all.position[corner] = way[k] + half * side, all.position[corner + 1] = way[k] - half * side;
            all.colour[corner] = all.colour[corner + 1] = colour[p];
        }
        for (int k = 0; k < pieces; ++k) {
            const auto c = static_cast<std::uint32_t>(corners * p + 2 * k);
            const std::uint32_t two[6] = {c, c + 1, c + 2, c + 2, c + 1, c + 3};
            std::copy(two, two + 6, all.index.begin() + indices * p + 6 * k);
        }
    });
    return all;
}

}  // namespace whorl
