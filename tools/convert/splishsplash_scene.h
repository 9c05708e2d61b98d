#pragma once
/// Contents of scenes of SPlisHSPlasH: placements, particles, the mesh UnitBox, methods and their parameters.
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/mesh.h"
#include "tools/convert/json_tree.h"

namespace whorl::splishsplash {

/// Placement of an object in a scene of SPlisHSPlasH: x = rotation (scale x_own) + translation.
struct Placement {
    Vec3d scale = Vec3d::Ones(), translation = Vec3d::Zero();
    Mat3d rotation = Mat3d::Identity();
    Vec3d operator()(const Vec3d& x) const { return rotation * scale.cwiseProduct(x) + translation; }
    bool turned() const { return !rotation.isIdentity(1e-9); }
};

inline Placement placement_of(const JsonNode& node) {
    Placement at;
    at.scale = node.vector_of("scale").value_or(at.scale);
    at.translation = node.vector_of("translation").value_or(at.translation);
    const Vec3d axis = node.vector_of("rotationAxis").value_or(Vec3d::UnitZ());
    const double angle = node.number_of("rotationAngle").value_or(0);
    if (angle != 0 && axis.norm() > 0) at.rotation = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    return at;
}

/// Box of edge 1, centred on the origin: the mesh UnitBox of SPlisHSPlasH, from which its scenes make walls.
inline TriangleMesh unit_box() {
    TriangleMesh box;
    for (int corner = 0; corner < 8; ++corner)
        box.position.push_back(Vec3f(corner & 1 ? 0.5f : -0.5f, corner & 2 ? 0.5f : -0.5f, corner & 4 ? 0.5f : -0.5f));
    box.triangle = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return box;
}

/// Positions of the particles in a Houdini file: .bgeo, version 5, optionally compressed (gzip). Format: big-endian counts, the names and
/// sizes of the points' attributes, then x, y, z, w and the attributes of each point. @throws InputError if the file is not of this format
std::vector<Vec3f> read_particles(const std::filesystem::path& file);
/// Surface around particles of this spacing [m].
TriangleMesh surface_of(const std::vector<Vec3f>& places, double spacing);

/// Names of the methods in SPlisHSPlasH, by their numbers from 1 on (pressure: from 0 on). Since version 2.16 the parameters of a method
/// are in a section with its name.
using Methods = std::vector<std::string_view>;
constexpr std::string_view standard = "Standard viscosity", takahashi = "Takahashi et al. 2015 (improved)", weiler = "Weiler et al. 2018",
                           xsph = "XSPH", zorilla = "Zorilla, Ritter, et al. 2020";
inline const Methods viscosities{standard, "Bender and Koschier 2017", "Peer et al. 2015", "Peer et al. 2016", takahashi, weiler},
    viscosities_before{standard, xsph, "Bender and Koschier 2017", "Peer et al. 2015", "Peer et al. 2016", takahashi, weiler},
    pressures{"WCSPH", "PCISPH", "PBF", "IISPH", "DFSPH", "Projective Fluids", "ICSPH"}, vorticities{"Bender et al. 2017"},
    tensions{"Becker & Teschner 2007", "Akinci et al. 2013", "He et al. 2014", "Jeske et al. 2023", zorilla};

/// Name of a method by its number; empty if there is no such number.
inline std::string_view name_of(const Methods& methods, double number, int first = 1) {
    const double k = number - first;
    return k >= 0 && k < static_cast<double>(methods.size()) ? methods[static_cast<std::size_t>(k)] : std::string_view();
}

/// Node with the parameters of a method: its section or, in files of versions before 2.16, the object that contains its number.
inline const JsonNode& section_of(const JsonNode& node, std::string_view method) {
    const JsonNode* found = node.find(std::string(method));
    return found && found->value.is_object() ? *found : node;
}

}  // namespace whorl::splishsplash
