#include "tests/support/exported.h"

#include <cstring>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "engine/io/csv.h"

namespace whorl::test {
namespace {

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
    T value{};
    if (at + sizeof value > bytes.size()) throw std::runtime_error("the file ends too early");
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

template <class T>
std::vector<T> numbers_at(const std::string& bytes, std::size_t at, std::size_t count) {
    std::vector<T> values;
    for (std::size_t k = 0; k < count; ++k) values.push_back(number_at<T>(bytes, at + k * sizeof(T)));
    return values;
}

}  // namespace

TriangleMesh tetrahedron() {
    TriangleMesh mesh;
    mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1.25f, 0}, {0, 0, 1e-3f}};
    mesh.normal = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.triangle = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    return mesh;
}

Ply read_ply(const std::filesystem::path& file) {
    const std::string bytes = read_whole(file), end = "end_header\n";
    Ply ply;
    std::size_t at = bytes.find(end) + end.size(), vertices = 0, faces = 0;
    ply.header = bytes.substr(0, at);
    std::istringstream lines(ply.header);
    std::vector<bool> is_whole;
    for (std::string line, word, kind, name; std::getline(lines, line);) {
        std::istringstream words(line);
        words >> word >> kind >> name;
        if (word == "element" && kind == "vertex") vertices = std::stoul(name);
        if (word == "element" && kind == "face") faces = std::stoul(name), ply.has_faces = true;
        if (word == "property" && kind != "list") ply.properties.push_back(name), is_whole.push_back(kind == "int");
    }
    for (std::size_t v = 0; v < vertices; ++v)
        for (std::size_t p = 0; p < ply.properties.size(); ++p, at += 4) {
            if (is_whole[p]) ply.whole[ply.properties[p]].push_back(number_at<std::int32_t>(bytes, at));
            else ply.number[ply.properties[p]].push_back(number_at<float>(bytes, at));
        }
    for (std::size_t f = 0; f < faces; ++f, at += 13) {
        if (bytes.at(at) != 3) throw std::runtime_error("a face is no triangle");
        std::array<std::uint32_t, 3> corners{};
        for (std::size_t c = 0; c < 3; ++c) corners[c] = number_at<std::uint32_t>(bytes, at + 1 + 4 * c);
        ply.face.push_back(corners);
    }
    if (at != bytes.size()) throw std::runtime_error("there is more in the file than its header says");
    return ply;
}

Vtk read_vtk(const std::filesystem::path& file) {
    const std::string bytes = read_whole(file), start = "<AppendedData encoding=\"raw\">\n_";
    Vtk vtk;
    const std::size_t data = bytes.find(start) + start.size();
    vtk.text = bytes.substr(0, data);
    static const std::regex array(
        "<DataArray type=\"(\\w+)\" Name=\"([^\"]+)\" NumberOfComponents=\"\\d\" format=\"appended\" offset=\"(\\d+)\"/>");
    std::size_t end = data;
    for (std::sregex_iterator found(vtk.text.begin(), vtk.text.end(), array), none; found != none; ++found) {
        const std::size_t at = data + std::stoul((*found)[3]), size = number_at<std::uint64_t>(bytes, at);
        if ((*found)[1] == "Int32") vtk.whole[(*found)[2]] = numbers_at<std::int32_t>(bytes, at + 8, size / 4);
        else vtk.number[(*found)[2]] = numbers_at<float>(bytes, at + 8, size / 4);
        end = at + 8 + size;
    }
    if (bytes.substr(end) != "\n</AppendedData>\n</VTKFile>\n") throw std::runtime_error("the arrays do not end where the file does");
    return vtk;
}

Glb read_glb(const std::filesystem::path& file) {
    const std::string bytes = read_whole(file);
    const auto word = [&](std::size_t at) { return std::size_t{number_at<std::uint32_t>(bytes, at)}; };
    if (bytes.substr(0, 4) != "glTF" || word(4) != 2 || word(8) != bytes.size()) throw std::runtime_error("no glTF 2.0");
    const std::size_t text = word(12), binary = 20 + text;
    if (bytes.substr(16, 4) != "JSON" || bytes.substr(binary + 4, 3) != "BIN" || text % 4 != 0 || word(binary) % 4 != 0 ||
        binary + 8 + word(binary) != bytes.size())
        throw std::runtime_error("the parts of the file are not in order");
    return {nlohmann::json::parse(bytes.substr(20, text)), bytes.substr(binary + 8)};
}

std::vector<float> Glb::floats(std::size_t number) const {
    const nlohmann::json& accessor = json.at("accessors").at(number);
    const nlohmann::json& view = json.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    static const std::map<std::string, std::size_t> components{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
    const std::size_t count = accessor.at("count").get<std::size_t>() * components.at(accessor.at("type").get<std::string>());
    if (accessor.at("componentType") != 5126 || view.at("byteLength") != 4 * count)
        throw std::runtime_error("an accessor does not fit its bytes");
    return numbers_at<float>(binary, view.at("byteOffset").get<std::size_t>(), count);
}

nlohmann::json Glb::node(const std::string& name) const {
    for (const auto& one : json.at("nodes"))
        if (one.value("name", "") == name) return one;
    return nullptr;
}

std::vector<float> Glb::keys(const std::string& name, const std::string& path) const {
    if (!json.contains("animations")) return {};
    const nlohmann::json& animation = json["animations"][0];
    for (const auto& channel : animation.at("channels"))
        if (json["nodes"][channel["target"]["node"].get<std::size_t>()]["name"] == name && channel["target"]["path"] == path)
            return floats(animation["samplers"][channel["sampler"].get<std::size_t>()]["output"].get<std::size_t>());
    return {};
}

}  // namespace whorl::test
