#include "render/export/attributes.h"

#include <bit>

#include "engine/core/errors.h"
#include "render/look/field_values.h"

namespace whorl {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little-endian, and numbers are copied from memory unchanged");
static_assert(sizeof(Vec3f) == 3 * sizeof(float));

const std::vector<std::string> exported_scalars{"density", "pressure", "viscosity", "q_criterion", "age", "temperature"};
const std::vector<std::string> exported_vectors{"spin", "vorticity", "spin_difference", "ink"};
const std::vector<std::string> exported_integers{"id", "source"};

template <class T>
void add_found(Attributes& to, const std::vector<std::string>& names, const std::map<std::string, std::vector<T>>& fields) {
    for (const std::string& name : names)
        if (const auto found = fields.find(name); found != fields.end()) to.add(name, found->second);
}

}  // namespace

const Attribute* Attributes::find(const std::string& name) const {
    for (const Attribute& a : all_)
        if (a.name == name) return &a;
    return nullptr;
}

void Attributes::add(const std::string& name, int components, bool integer, const void* data, std::size_t rows) {
    WHORL_ASSERT(rows == rows_, +name + " has " + std::to_string(rows) + " rows of " + std::to_string(rows_));
    all_.push_back({name, components, integer, data});
}

void Attributes::add(const std::string& name, const std::vector<Vec3f>& values) { add(name, 3, false, values.data(), values.size()); }
void Attributes::add(const std::string& name, const std::vector<float>& values) { add(name, 1, false, values.data(), values.size()); }
void Attributes::add(const std::string& name, const std::vector<std::int32_t>& values) { add(name, 1, true, values.data(), values.size()); }

void Attributes::add_constant(const std::string& name, float value) { add(name, owned_.emplace_back(rows_, value)); }

std::string name_with_unit(const std::string& attribute) {
    const std::string unit = unit_of(attribute);
    return unit.empty() ? attribute : attribute + " [" + unit + "]";
}

std::vector<std::string> component_names(const Attribute& attribute) {
    if (attribute.components == 1) return {attribute.name};
    if (attribute.name == "position") return {"x", "y", "z"};
    if (attribute.name == "normal") return {"nx", "ny", "nz"};
    std::vector<std::string> names;
    for (const char* end : attribute.name == "ink" ? std::array{"_1", "_2", "_3"} : std::array{"_x", "_y", "_z"})
        names.push_back(attribute.name + end);
    return names;
}

Attributes particle_attributes(const Frame& frame) {
    Attributes all(frame.position.size());
    all.add("position", frame.position);
    all.add("velocity", frame.velocity);
    add_found(all, exported_scalars, frame.scalar);
    add_found(all, exported_vectors, frame.vector);
    all.add_constant("radius", frame.spacing / 2);
    add_found(all, exported_integers, frame.whole);
    return all;
}

Attributes vertex_attributes(const TriangleMesh& mesh, const VertexFields& fields) {
    Attributes all(mesh.position.size());
    all.add("position", mesh.position);
    if (mesh.normal.size() == mesh.position.size()) all.add("normal", mesh.normal);
    for (const auto& [name, values] : fields.vector) all.add(name, values);
    for (const auto& [name, values] : fields.scalar) all.add(name, values);
    return all;
}

std::vector<std::string> fields_of_particles() {
    return {"density", "pressure", "viscosity", "spin", "ink", "age", "temperature", "id", "source"};
}
std::vector<std::string> fields_of_surface() { return {"viscosity", "ink", "age", "temperature"}; }

}  // namespace whorl
