#pragma once
/// Named arrays with one row per particle or vertex, for files that other programs read; PLY and OBJ files.
#include <array>
#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/io/frame.h"
#include "render/surface/vertex_values.h"

namespace whorl {

/// An array of 4-byte numbers. It does not own them.
struct Attribute {
    std::string name;  ///< "velocity"
    int components = 1;
    bool integer = false;        ///< true: 32-bit integers, false: floats
    const void* data = nullptr;  ///< row by row
};

/// Attributes with the same number of rows. The arrays passed to add() must outlive them.
class Attributes {
public:
    explicit Attributes(std::size_t rows) : rows_(rows) {}
    std::size_t rows() const { return rows_; }
    const std::vector<Attribute>& all() const { return all_; }
    /// Null if no attribute has that name.
    const Attribute* find(const std::string& name) const;

    void add(const std::string& name, const std::vector<Vec3f>& values);
    void add(const std::string& name, const std::vector<float>& values);
    void add(const std::string& name, const std::vector<std::int32_t>& values);
    /// Adds an attribute with one value for all rows.
    void add_constant(const std::string& name, float value);

private:
    void add(const std::string& name, int components, bool integer, const void* data, std::size_t rows);
    std::size_t rows_;
    std::vector<Attribute> all_;
    std::deque<std::vector<float>> owned_;
};

/// Name with its unit, "velocity [m/s]"; without a unit the name alone, "ink".
std::string name_with_unit(const std::string& attribute);
/// Column names of the components in a table: x, y, z (position), nx, ny, nz (normal), ink_1, ink_2, ink_3, velocity_x, ...
std::vector<std::string> component_names(const Attribute& attribute);

/// Attributes of the particles that the frame contains: position, velocity, density, pressure, viscosity, q_criterion, age, spin,
/// vorticity, spin_difference, ink, radius (half a spacing), id, source. Internal fields of the solver are left out.
Attributes particle_attributes(const Frame& frame);
/// Position, normal (if the mesh has normals) and fields of the vertices.
Attributes vertex_attributes(const TriangleMesh& mesh, const VertexFields& fields);

/// Names of the columns that a run must store in its frames for files of particles, or of the surface.
std::vector<std::string> fields_of_particles();
std::vector<std::string> fields_of_surface();

/// Atomically writes a binary little-endian PLY file, one vertex per row. Every property is a 4-byte float or int, named by
/// component_names(). Comments in the file give the frame and the units. @throws EnvironmentError
/// @param triangles null: points, no faces
void write_ply(const std::filesystem::path& file, const Frame& frame, const Attributes& vertices,
               const std::vector<std::array<std::uint32_t, 3>>* triangles = nullptr);

/// Atomically writes the positions and triangles of a mesh, and its normals if it has any. OBJ has no other fields. @throws
/// EnvironmentError
void write_obj_mesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace whorl
