#pragma once
/// Named arrays, one row per particle or vertex: content of the files for other programs.
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "engine/io/frame.h"
#include "render/surface/vertex_values.h"

namespace whorl {

/// Rows of numbers of four bytes each.
struct Attribute {
    std::string name;  ///< "velocity"
    int components = 1;
    bool integer = false;        ///< 32-bit whole numbers, else floats
    const void* data = nullptr;  ///< row after row
};

/// Attributes with the same number of rows. It points into its source, which must outlive it.
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

/// "velocity [m/s]"; "ink".
std::string name_with_unit(const std::string& attribute);
/// Column names in tables: x, y, z of the position, nx, ny, nz of the normal, ink_1, ink_2, ink_3; else velocity_x, ...
std::vector<std::string> component_names(const Attribute& attribute);

/// Attributes of each particle for other programs, if the frame has them: position, velocity, density, pressure, viscosity, spin,
/// vorticity, q_criterion, spin_difference, ink, age, radius (half a spacing), id, source. No internal fields of the solver.
Attributes particle_attributes(const Frame& frame);
/// Position and normal of each vertex, and the fluid's values there.
Attributes vertex_attributes(const TriangleMesh& mesh, const VertexFields& fields);

/// The columns that a run has to put into its frames for these files, by their names there.
std::vector<std::string> fields_of_particles();
std::vector<std::string> fields_of_surface();

}  // namespace whorl
