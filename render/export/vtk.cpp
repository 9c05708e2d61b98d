#include <fmt/format.h>

#include "engine/core/atomic_file.h"
#include "engine/core/parallel.h"
#include "render/export/gltf.h"

namespace whorl {
namespace {

/// Binary part of a file: its arrays in sequence, each after its size in bytes.
class Appended {
public:
    /// Appends an array. @return the XML element that refers to it
    std::string array(const std::string& name, const char* type, int components, const void* data, std::size_t bytes) {
        const std::string element =
            fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type, name,
                        components, bytes_.size());
        const auto size = static_cast<std::uint64_t>(bytes);
        bytes_.append(reinterpret_cast<const char*>(&size), sizeof size);
        bytes_.append(static_cast<const char*>(data), bytes);
        return element;
    }
    std::string array(const Attribute& a, std::size_t rows) {
        return array(name_with_unit(a.name), a.integer ? "Int32" : "Float32", a.components, a.data,
                     4 * rows * static_cast<std::size_t>(a.components));
    }
    std::string whole_numbers(const char* name, const std::vector<std::int32_t>& values) {
        return array(name, "Int32", 1, values.data(), values.size() * sizeof values[0]);
    }
    const std::string& bytes() const { return bytes_; }

private:
    std::string bytes_;
};

std::string document(const char* kind, const std::string& attributes, double time, const std::string& content, const Appended& data) {
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{0}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<{0}{1}>\n"
        "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{2:.17g}</DataArray></FieldData>\n"
        "{3}</{0}>\n<AppendedData encoding=\"raw\">\n_",
        kind, attributes, time, content);
    text += data.bytes();
    return text + "\n</AppendedData>\n</VTKFile>\n";
}

/// The n integers first, first + step, first + 2 step, ...
std::vector<std::int32_t> counted(std::size_t n, std::int32_t first, std::int32_t step) {
    std::vector<std::int32_t> values(n);
    for (std::size_t k = 0; k < n; ++k) values[k] = first + step * static_cast<std::int32_t>(k);
    return values;
}

std::string escaped(const std::string& text) {
    std::string safe;
    for (const char c : text) safe += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
    return safe;
}

/// A field on the nodes of a grid.
struct NodeArray {
    std::string name;
    int components = 1;
    std::vector<float> value;
};

/// Particle attributes interpolated to the nodes, four components per pass over the grid. @param grid receives the grid, with velocity and
/// cover (FlowGrid)
std::vector<NodeArray> on_nodes(const Frame& frame, const Attributes& particles, FlowGrid& grid) {
    struct Slot {
        const float* from;  // component of the first particle
        int stride;
        std::size_t array;
        int component;
    };
    std::vector<NodeArray> arrays;
    std::vector<Slot> slots;
    for (const Attribute& a : particles.all()) {
        if (a.integer || a.name == "position" || a.name == "velocity" || a.name == "radius") continue;
        for (int c = 0; c < a.components; ++c) slots.push_back({static_cast<const float*>(a.data) + c, a.components, arrays.size(), c});
        arrays.push_back({a.name, a.components, {}});
    }
    const float cell = frame.dimensions == 2 ? 0.5f : 1;
    for (std::size_t first = 0; first == 0 || first < slots.size(); first += 4) {
        const std::size_t count = std::min<std::size_t>(4, slots.size() - first);
        std::vector<Eigen::Vector4f> value(count > 0 ? frame.position.size() : 0, Eigen::Vector4f::Zero());
        for (std::size_t p = 0; p < value.size(); ++p)
            for (std::size_t s = 0; s < count; ++s)
                value[p][static_cast<int>(s)] = slots[first + s].from[p * static_cast<std::size_t>(slots[first + s].stride)];
        grid = flow_grid(frame, frame.velocity, value, 8'000'000, cell);
        for (std::size_t s = 0; s < count; ++s) {
            NodeArray& array = arrays[slots[first + s].array];
            array.value.resize(grid.cover.size() * static_cast<std::size_t>(array.components));
            for (std::size_t node = 0; node < grid.cover.size(); ++node)
                array.value[node * static_cast<std::size_t>(array.components) + static_cast<std::size_t>(slots[first + s].component)] =
                    grid.value[node][static_cast<int>(s)];
        }
    }
    const auto numbers = [&](const char* name, int components, const float* from) {
        arrays.push_back({name, components, {from, from + static_cast<std::size_t>(components) * grid.cover.size()}});
    };
    if (grid.empty()) return arrays;
    numbers("velocity", 3, grid.along[0].data());
    numbers("cover", 1, grid.cover.data());
    return arrays;
}

/// The array with the first layer of nodes of each periodic axis repeated at its end. @param n nodes of the result
std::vector<float> closed(const NodeArray& array, const FlowGrid& grid, const std::array<int, 3>& n) {
    const auto components = static_cast<std::size_t>(array.components);
    std::vector<float> all;
    all.reserve(components * grid_count(n[0], n[1], n[2]));
    for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
                const std::size_t from = components * grid.index(i % grid.n[0], j % grid.n[1], k % grid.n[2]);
                for (std::size_t c = 0; c < components; ++c) all.push_back(array.value[from + c]);
            }
    return all;
}

}  // namespace

void write_vtp(const std::filesystem::path& file, double time, const Attributes& points,
               const std::vector<std::array<std::uint32_t, 3>>* triangles) {
    Appended data;
    const std::size_t rows = points.rows(), faces = triangles ? triangles->size() : 0;
    std::string content = fmt::format(
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n<PointData "
        "Vectors=\"velocity [m/s]\"{}>\n",
        rows, triangles ? 0 : rows, faces, points.find("normal") ? " Normals=\"normal\"" : "");
    for (const Attribute& a : points.all())
        if (a.name != "position") content += data.array(a, rows);
    content += "</PointData>\n<Points>\n" + data.array(*points.find("position"), rows) + "</Points>\n";
    const char* cells = triangles ? "Polys" : "Verts";
    content += fmt::format("<{}>\n", cells);
    if (triangles) {
        content += data.array("connectivity", "Int32", 1, triangles->data(), faces * sizeof(std::array<std::uint32_t, 3>));
        content += data.whole_numbers("offsets", counted(faces, 3, 3));
    } else {
        content += data.whole_numbers("connectivity", counted(rows, 0, 1));
        content += data.whole_numbers("offsets", counted(rows, 1, 1));
    }
    content += fmt::format("</{}>\n</Piece>\n", cells);
    write_text(file, document("PolyData", "", time, content, data));
}

void write_vti(const std::filesystem::path& file, const Frame& frame, const Attributes& particles) {
    FlowGrid grid;
    const std::vector<NodeArray> arrays = on_nodes(frame, particles, grid);
    const bool plane = frame.dimensions == 2;
    std::array<int, 3> n = grid.n;
    for (int a = 0; a < 3; ++a)
        if (grid.periodic[a] && !(plane && a == 2)) ++n[a];
    const Vec3f origin(grid.origin.x(), grid.origin.y(), plane ? 0 : grid.origin.z());
    const std::string extent = fmt::format("0 {} 0 {} 0 {}", n[0] - 1, n[1] - 1, n[2] - 1);
    Appended data;
    std::string content = fmt::format("<Piece Extent=\"{}\">\n<PointData Scalars=\"cover\" Vectors=\"velocity [m/s]\">\n", extent);
    for (const NodeArray& array : arrays) {
        if (grid.empty()) break;
        const std::vector<float> values = closed(array, grid, n);
        content += data.array(name_with_unit(array.name), "Float32", array.components, values.data(), values.size() * sizeof(float));
    }
    content += "</PointData>\n</Piece>\n";
    const std::string attributes = fmt::format(" WholeExtent=\"{}\" Origin=\"{:.9g} {:.9g} {:.9g}\" Spacing=\"{:.9g} {:.9g} {:.9g}\"",
                                               extent, origin.x(), origin.y(), origin.z(), grid.cell.x(), grid.cell.y(), grid.cell.z());
    write_text(file, document("ImageData", attributes, frame.time, content, data));
}

void write_pvd(const std::filesystem::path& file, const std::vector<TimedFile>& files) {
    std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
    std::vector<std::string> parts;
    for (const TimedFile& one : files) {
        auto part = std::find(parts.begin(), parts.end(), one.part);
        if (part == parts.end()) part = parts.insert(parts.end(), one.part);
        text += fmt::format("<DataSet timestep=\"{:.17g}\" part=\"{}\" name=\"{}\" file=\"{}\"/>\n", one.time, part - parts.begin(),
                            one.part, escaped(one.file));
    }
    write_text(file, text + "</Collection>\n</VTKFile>\n");
}

}  // namespace whorl
