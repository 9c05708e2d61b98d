#include "engine/geometry/mesh_file.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "engine/core/errors.h"

namespace whorl {
namespace {

using Corner = std::uint32_t;

/// A text file line by line, word by word.
class Words {
public:
    /// @param joins a line that ends in "\" goes on in the next one
    Words(const std::string& file, std::string_view text, bool joins = false) : file_(file), rest_(text), joins_(joins) {}

    /// Goes to the next line; false at the end.
    bool next_line() {
        if (rest_.empty()) return false;
        const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
        line_text_ = rest_.substr(0, end), column_ = 1;
        rest_.remove_prefix(end);
        rest_.remove_prefix(rest_.starts_with("\r\r\n") ? 3 : rest_.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, rest_.size()));
        ++line_;
        goes_on_ = joins_ && line_text_.ends_with('\\');
        if (goes_on_) line_text_.remove_suffix(1);
        words_ = line_text_;
        return true;
    }
    /// The next word of this line, empty at its end.
    std::string_view word() {
        std::size_t begin = words_.find_first_not_of(" \t");
        while (begin == words_.npos && goes_on_ && next_line()) begin = words_.find_first_not_of(" \t");
        begin = std::min(begin, words_.size());
        column_ = static_cast<int>(line_text_.size() - words_.size() + begin) + 1;
        words_.remove_prefix(begin);
        const std::size_t end = std::min(words_.find_first_of(" \t"), words_.size());
        const std::string_view found = words_.substr(0, end);
        words_.remove_prefix(end);
        return found;
    }
    template <class T>
    T whole(std::string_view text) const {
        T value{};
        const std::errc error = read(text, value);
        if (error != std::errc()) fail(not_a_number(text, error), "allowed: whole numbers");
        return value;
    }
    /// @param most what the number may be either way; where that is infinite, it may be nan as well
    double number(std::string_view text, double most = std::numeric_limits<double>::max()) const {
        double value = 0;
        std::errc error = read(text, value);
        if (error == std::errc::result_out_of_range) error = {}, value = std::strtod(std::string(text).c_str(), nullptr);  // 0 or infinite
        if (error == std::errc() && std::abs(value) > most) error = std::errc::result_out_of_range;
        if (error != std::errc() || (std::isnan(value) && std::isfinite(most)))
            fail(not_a_number(text, error), std::isfinite(most) ? fmt::format("allowed: numbers from {:.2g} to {:.2g}", -most, most) : "");
        return value;
    }
    Vec3f point() {
        Vec3f x;
        for (int a = 0; a < 3; ++a) x[a] = static_cast<float>(number(word(), std::numeric_limits<float>::max()));
        return x;
    }
    std::string_view rest() const { return rest_; }
    int line() const { return line_; }
    /// At the last word that was taken.
    [[noreturn]] void fail(const std::string& what, const std::string& allowed = "") const {
        throw InputError({file_, line_, column_}, what, "", allowed);
    }

private:
    /// All of the text as a number.
    template <class T>
    static std::errc read(std::string_view text, T& value) {
        if (!text.empty() && text.front() == '+') text.remove_prefix(1);
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        return end == text.data() + text.size() ? error : std::errc::invalid_argument;
    }
    static std::string not_a_number(std::string_view text, std::errc error) {
        const bool too_large = error == std::errc::result_out_of_range;
        return text.empty() ? "a number is missing" : fmt::format("\"{}\" {}", text, too_large ? "is too large" : "is not a number");
    }

    std::string file_;
    std::string_view rest_, line_text_, words_;
    bool joins_, goes_on_ = false;
    int line_ = 0, column_ = 0;
};

void add_polygon(TriangleMesh& mesh, const std::vector<Corner>& corners) {
    for (std::size_t k = 2; k < corners.size(); ++k) mesh.triangle.push_back({corners[0], corners[k - 1], corners[k]});
}

TriangleMesh read_obj(const std::string& file, std::string_view text) {
    TriangleMesh mesh;
    Words words(file, text, true);
    std::vector<Corner> corners;
    while (words.next_line()) {
        const std::string_view key = words.word();
        if (key == "v") {
            mesh.position.push_back(words.point());
        } else if (key == "f") {
            corners.clear();
            for (std::string_view corner = words.word(); !corner.empty(); corner = words.word()) {
                const long long count = static_cast<long long>(mesh.position.size());
                long long index = words.whole<long long>(corner.substr(0, corner.find('/')));
                if (index < 0) index += count + 1;  // counted from the newest vertex
                if (index < 1 || index > count) words.fail(fmt::format("face refers to vertex {}, there are {} so far", corner, count));
                corners.push_back(static_cast<Corner>(index - 1));
            }
            if (corners.size() < 3) words.fail("a face needs at least three vertices");
            add_polygon(mesh, corners);
        }
    }
    return mesh;
}

TriangleMesh read_ascii_stl(const std::string& file, std::string_view text) {
    TriangleMesh mesh;
    Words words(file, text);
    std::vector<Corner> corners;
    while (words.next_line()) {
        const std::string_view key = words.word();
        if (key == "vertex") {
            corners.push_back(static_cast<Corner>(mesh.position.size()));
            mesh.position.push_back(words.point());
        } else if (key == "endloop") {
            if (corners.size() != 3) words.fail(fmt::format("a facet has {} vertices", corners.size()));
            add_polygon(mesh, corners);
            corners.clear();
        }
    }
    if (!corners.empty()) words.fail("the file ends inside a facet");
    return mesh;
}

template <class T>
T bytes_as(const char* bytes) {
    static_assert(std::endian::native == std::endian::little);
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

TriangleMesh read_binary_stl(const std::string& file, std::string_view text) {
    const std::size_t count = bytes_as<std::uint32_t>(text.data() + 80);
    if (text.size() < 84 + 50 * count)
        throw InputError({file}, fmt::format("cut short: {} triangles announced, {} there", count, (text.size() - 84) / 50));
    TriangleMesh mesh;
    for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            Vec3f x;
            for (std::size_t a = 0; a < 3; ++a)
                x[static_cast<int>(a)] = bytes_as<float>(text.data() + 84 + 50 * k + 12 + 12 * corner + 4 * a);
            if (!x.allFinite()) throw InputError({file}, fmt::format("a coordinate of triangle {} is not finite", k + 1));
            mesh.position.push_back(x);
        }
        const Corner first = static_cast<Corner>(3 * k);
        mesh.triangle.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

/// A property of a PLY element; a list has a type for its length too.
struct PlyProperty {
    std::string name, type, length_type;
};
struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;
};

std::size_t ply_size(const std::string& type) {
    static const std::map<std::string, std::size_t> sizes{
        {"char", 1}, {"uchar", 1}, {"int8", 1},  {"uint8", 1},  {"short", 2}, {"ushort", 2},  {"int16", 2},  {"uint16", 2},
        {"int", 4},  {"uint", 4},  {"int32", 4}, {"uint32", 4}, {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
    const auto it = sizes.find(type);
    return it == sizes.end() ? 0 : it->second;
}

double ply_value(const std::string& type, const char* bytes) {
    if (type == "float" || type == "float32") return bytes_as<float>(bytes);
    if (type == "double" || type == "float64") return bytes_as<double>(bytes);
    const bool is_unsigned = type[0] == 'u';
    switch (ply_size(type)) {
        case 1: return is_unsigned ? bytes_as<std::uint8_t>(bytes) : bytes_as<std::int8_t>(bytes);
        case 2: return is_unsigned ? bytes_as<std::uint16_t>(bytes) : bytes_as<std::int16_t>(bytes);
        default: return is_unsigned ? bytes_as<std::uint32_t>(bytes) : bytes_as<std::int32_t>(bytes);
    }
}

TriangleMesh read_ply(const std::string& file, std::string_view text) {
    Words words(file, text);
    std::vector<PlyElement> elements;
    bool binary = false, ended = false;
    while (!ended && words.next_line()) {
        const std::string key(words.word());
        if (key == "format") {
            const std::string format(words.word());
            if (format != "ascii" && format != "binary_little_endian")
                words.fail("PLY format " + format + " is not read; allowed: ascii, binary_little_endian");
            binary = format != "ascii";
        } else if (key == "element") {
            PlyElement element{std::string(words.word()), 0, {}};
            element.count = words.whole<std::size_t>(words.word());
            elements.push_back(element);
        } else if (key == "property") {
            if (elements.empty()) words.fail("a property before the first element");
            PlyProperty property;
            property.type = words.word();
            if (property.type == "list") {
                property.length_type = words.word();
                property.type = words.word();
                if (ply_size(property.length_type) == 0) words.fail("type " + property.length_type + " is not known");
            }
            property.name = words.word();
            if (ply_size(property.type) == 0) words.fail("type " + property.type + " is not known");
            elements.back().properties.push_back(property);
        } else if (key == "end_header") {
            ended = true;
        }
    }
    if (!ended) words.fail("the header has no end");
    for (const PlyElement& element : elements)
        if (element.count > 0 && element.properties.empty()) words.fail("element " + element.name + " has no property");

    std::string_view bytes = words.rest();
    const auto next = [&](const std::string& type, bool is_read) {
        if (!binary)
            return words.number(words.word(), is_read ? std::numeric_limits<double>::max() : std::numeric_limits<double>::infinity());
        const std::size_t size = ply_size(type);
        if (bytes.size() < size) throw InputError({file}, "cut short");
        const double value = ply_value(type, bytes.data());
        bytes.remove_prefix(size);
        return value;
    };
    TriangleMesh mesh;
    std::vector<Corner> corners;
    for (const PlyElement& element : elements)
        for (std::size_t k = 0; k < element.count; ++k) {
            if (!binary && !words.next_line()) words.fail(fmt::format("the file ends at {} {} of {}", element.name, k + 1, element.count));
            Vec3f x = Vec3f::Zero();
            for (const PlyProperty& property : element.properties) {
                const bool list = !property.length_type.empty();
                const bool is_face =
                    list && element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
                const bool is_place =
                    !list && element.name == "vertex" && (property.name == "x" || property.name == "y" || property.name == "z");
                const double length = list ? next(property.length_type, true) : 1;
                if (!(length >= 0 && length < 1e6)) words.fail("a list has an impossible length");
                corners.clear();
                for (int l = 0; l < static_cast<int>(length); ++l) {
                    const double value = next(property.type, is_face || is_place);
                    if (list) corners.push_back(value >= 0 && value < ~Corner(0) ? static_cast<Corner>(value) : ~Corner(0));
                    else if (is_place) x[property.name[0] - 'x'] = static_cast<float>(value);
                }
                if (is_face) add_polygon(mesh, corners);
            }
            if (element.name == "vertex") {
                if (!x.allFinite()) words.fail(fmt::format("vertex {} is not finite in single precision", k));
                mesh.position.push_back(x);
            }
        }
    for (const auto& t : mesh.triangle)
        for (Corner c : t)
            if (c >= mesh.position.size())
                throw InputError(
                    {file}, fmt::format("a face refers to a vertex that is not there: there are {}, counted from 0", mesh.position.size()));
    return mesh;
}

}  // namespace

void weld(TriangleMesh& mesh) {
    const auto less = [](const Vec3f& a, const Vec3f& b) {
        return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    };
    std::map<Vec3f, Corner, decltype(less)> vertex(less);
    TriangleMesh welded;
    std::vector<Corner> to(mesh.position.size());
    for (std::size_t k = 0; k < mesh.position.size(); ++k) {
        const auto [it, is_new] = vertex.try_emplace(mesh.position[k], static_cast<Corner>(welded.position.size()));
        if (is_new) welded.position.push_back(mesh.position[k]);
        to[k] = it->second;
    }
    for (const auto& t : mesh.triangle) {
        const std::array<Corner, 3> corner{to[t[0]], to[t[1]], to[t[2]]};
        if (corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0]) welded.triangle.push_back(corner);
    }
    mesh = std::move(welded);
}

TriangleMesh read_mesh(const std::filesystem::path& file) {
    const std::string name = file.string();
    std::ifstream in(file, std::ios::binary);
    std::error_code none;
    if (!in || !std::filesystem::is_regular_file(file, none)) throw InputError({name}, "the mesh file cannot be opened");
    std::stringstream buffer;
    buffer << in.rdbuf();
    const std::string bytes = buffer.str();
    std::string_view text = bytes;

    std::string kind = file.extension().string();
    for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    // A binary file may begin with "solid" too: its size tells.
    const bool binary =
        kind == ".stl" && text.size() >= 84 && text.size() == 84 + 50 * std::size_t(bytes_as<std::uint32_t>(text.data() + 80));
    if (!binary && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // a byte-order mark
    TriangleMesh mesh;
    if (kind == ".obj") {
        mesh = read_obj(name, text);
    } else if (kind == ".ply") {
        mesh = read_ply(name, text);
    } else if (kind == ".stl") {
        if (binary || (text.rfind("solid", 0) != 0 && text.size() >= 84)) mesh = read_binary_stl(name, text);
        else mesh = read_ascii_stl(name, text);
    } else {
        throw InputError({name}, "\"" + kind + "\" is not a kind of mesh file", "", ".obj, .ply, .stl");
    }
    if (mesh.triangle.empty()) throw InputError({name}, "the file holds no triangles");
    weld(mesh);
    return mesh;
}

}  // namespace whorl
