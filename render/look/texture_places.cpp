#include "render/look/texture_places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>

namespace whorl {
namespace {

struct ObjCorner {
    int vertex, place;
};
struct ObjMesh {
    std::vector<Vec3f> position;
    std::vector<Eigen::Vector2f> place;
    std::vector<std::vector<ObjCorner>> face;  ///< only those with texture coordinates
};

/// The engine has read the file before, so faults are ignored here.
ObjMesh read_places(const std::filesystem::path& file) {
    ObjMesh mesh;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") words >> mesh.position.emplace_back(0, 0, 0).x() >> mesh.position.back().y() >> mesh.position.back().z();
        if (word == "vt") words >> mesh.place.emplace_back(0, 0).x() >> mesh.place.back().y();
        if (word != "f") continue;
        std::vector<ObjCorner> face;
        while (words >> word) {
            ObjCorner corner{0, 0};
            if (std::sscanf(word.c_str(), "%d/%d", &corner.vertex, &corner.place) != 2) break;
            corner.vertex += corner.vertex < 0 ? static_cast<int>(mesh.position.size()) : -1;
            corner.place += corner.place < 0 ? static_cast<int>(mesh.place.size()) : -1;
            const bool known = corner.vertex >= 0 && corner.vertex < static_cast<int>(mesh.position.size()) && corner.place >= 0 &&
                               corner.place < static_cast<int>(mesh.place.size());
            if (known) face.push_back(corner);
        }
        if (face.size() > 2) mesh.face.push_back(std::move(face));
    }
    return mesh;
}

/// Maps the bounds of points to a cube of side 1.
class UnitCube {
public:
    explicit UnitCube(const std::vector<Vec3f>& points) {
        Eigen::AlignedBox3f box;
        for (const Vec3f& x : points) box.extend(x);
        low_ = box.min(), scale_ = 1 / std::max(box.sizes().maxCoeff(), 1e-20f);
    }
    Vec3f operator()(const Vec3f& x) const { return scale_ * (x - low_); }

private:
    Vec3f low_;
    float scale_;
};

constexpr float cell = 2e-4f;  ///< points of both meshes that are nearer are the same
using Cell = std::array<int, 3>;
Cell cell_of(const Vec3f& x) {
    const Vec3f k = (x / cell).array().floor();
    return {static_cast<int>(k.x()), static_cast<int>(k.y()), static_cast<int>(k.z())};
}

}  // namespace

std::vector<Eigen::Vector2f> texture_places(const TriangleMesh& mesh, const std::filesystem::path& file) {
    const ObjMesh obj = file.extension() == ".obj" || file.extension() == ".OBJ" ? read_places(file) : ObjMesh{};
    if (obj.face.empty() || mesh.triangle.empty()) return {};
    const UnitCube of_file(obj.position), of_mesh(mesh.position);
    std::map<Cell, std::vector<int>> faces;  // those with a corner in the cell
    for (std::size_t f = 0; f < obj.face.size(); ++f)
        for (const ObjCorner& c : obj.face[f]) faces[cell_of(of_file(obj.position[c.vertex]))].push_back(static_cast<int>(f));

    const auto corner_at = [&](int f, const Vec3f& x) -> const ObjCorner* {
        for (const ObjCorner& c : obj.face[f])
            if ((of_file(obj.position[c.vertex]) - x).norm() < cell) return &c;
        return nullptr;
    };
    const auto find = [&](const std::array<Vec3f, 3>& x) -> std::optional<std::array<const ObjCorner*, 3>> {
        const Cell middle = cell_of(x[0]);
        for (int n = 0; n < 27; ++n) {
            const auto near = faces.find({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1});
            if (near == faces.end()) continue;
            for (const int f : near->second) {
                const std::array corner{corner_at(f, x[0]), corner_at(f, x[1]), corner_at(f, x[2])};
                if (corner[0] != nullptr && corner[1] != nullptr && corner[2] != nullptr) return corner;
            }
        }
        return std::nullopt;
    };
    std::vector<Eigen::Vector2f> places;
    std::size_t found = 0;
    for (const auto& t : mesh.triangle) {
        const auto corners = find({of_mesh(mesh.position[t[0]]), of_mesh(mesh.position[t[1]]), of_mesh(mesh.position[t[2]])});
        found += corners.has_value();
        for (int k = 0; k < 3; ++k) places.push_back(corners ? obj.place[(*corners)[k]->place] : Eigen::Vector2f(0, 0));
    }
    return 2 * found > mesh.triangle.size() ? places : std::vector<Eigen::Vector2f>{};
}

}  // namespace whorl
