#include <functional>
#include <map>
#include <optional>

#include "engine/geometry/mesh_text.h"

namespace whorl {
namespace {

/// A property of a PLY element. Type letters: b, h, i for integers of 1, 2, 4 bytes (capital: unsigned); f, d for floats of 4, 8 bytes.
struct PlyProperty {
    std::string name;
    char type = 0, length_type = 0;  ///< length_type: type of a list's length, 0 if it is not a list
};
struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;
};

/// Reads a value from the front of the bytes; empty if there are too few.
std::optional<double> ply_value(char type, std::string_view& bytes, bool swapped) {
    const auto take = [&]<class T>(T) -> std::optional<double> {
        if (bytes.size() < sizeof(T)) return {};
        const T value = bytes_as<T>(bytes.data(), swapped);
        bytes.remove_prefix(sizeof(T));
        return static_cast<double>(value);
    };
    switch (type) {
        case 'b': return take(std::int8_t{});
        case 'B': return take(std::uint8_t{});
        case 'h': return take(std::int16_t{});
        case 'H': return take(std::uint16_t{});
        case 'i': return take(std::int32_t{});
        case 'I': return take(std::uint32_t{});
        case 'f': return take(float{});
        default: return take(double{});
    }
}

class PlyReader {
public:
    PlyReader(const std::string& file, std::string_view text) : file_(file), words_(file, text) {}

    Polygons read() {
        read_header();
        bytes_ = words_.rest();
        for (const PlyElement& element : elements_) {
            if (element.count > 0 && element.properties.empty()) words_.fail("element " + element.name + " has no property");
            for (std::size_t k = 0; k < element.count; ++k) read_entry(element, k);
        }
        return std::move(mesh_);
    }

private:
    char type_of(std::string_view name) const {
        static const std::map<std::string, char, std::less<>> types{{"char", 'b'},  {"int8", 'b'},    {"uchar", 'B'},  {"uint8", 'B'},
                                                                    {"short", 'h'}, {"int16", 'h'},   {"ushort", 'H'}, {"uint16", 'H'},
                                                                    {"int", 'i'},   {"int32", 'i'},   {"uint", 'I'},   {"uint32", 'I'},
                                                                    {"float", 'f'}, {"float32", 'f'}, {"double", 'd'}, {"float64", 'd'}};
        const auto found = types.find(name);
        if (found == types.end()) words_.fail(fmt::format("type {} is not known", name));
        return found->second;
    }

    void read_header() {
        std::string format;
        bool ended = false;
        while (!ended && words_.next_line()) {
            const std::string_view key = words_.word();
            if (key == "format") {
                format = words_.word();
                if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian")
                    words_.fail("PLY format " + format + " is not read; allowed: ascii, binary_little_endian, binary_big_endian");
            } else if (key == "element") {
                const std::string name(words_.word());
                elements_.push_back({name, words_.whole<std::size_t>(words_.word()), {}});
            } else if (key == "property") {
                if (elements_.empty()) words_.fail("a property before the first element");
                PlyProperty property;
                std::string_view type = words_.word();
                if (type == "list") property.length_type = type_of(words_.word()), type = words_.word();
                property.type = type_of(type);
                property.name = words_.word();
                elements_.back().properties.push_back(property);
            }
            ended = key == "end_header";
        }
        if (!ended) words_.fail("the header has no line end_header");
        binary_ = format.starts_with('b'), swapped_ = format == "binary_big_endian";
    }

    /// The next value of entry k of an element. @param is_read whether the value must be finite
    double next(char type, bool is_read, const PlyElement& element, std::size_t k) {
        if (!binary_)
            return words_.number(words_.word(), is_read ? std::numeric_limits<double>::max() : std::numeric_limits<double>::infinity());
        if (const auto value = ply_value(type, bytes_, swapped_)) return *value;
        throw InputError({file_}, fmt::format("cut short: it ends at {} {} of {}", element.name, k + 1, element.count));
    }

    void read_entry(const PlyElement& element, std::size_t k) {
        if (!binary_ && !words_.next_full_line())
            words_.fail(fmt::format("the file ends at {} {} of {}", element.name, k + 1, element.count));
        const bool is_vertex = element.name == "vertex";
        Vec3d x = Vec3d::Zero();
        for (const PlyProperty& property : element.properties) {
            const bool list = property.length_type != 0;
            const bool is_face = list && element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
            const bool is_place = !list && is_vertex && (property.name == "x" || property.name == "y" || property.name == "z");
            const double length = list ? next(property.length_type, true, element, k) : 1;
            if (!(length >= 0 && length < 1e6)) words_.fail("a list has an impossible length");
            corners_.clear();
            for (int l = 0; l < static_cast<int>(length); ++l) {
                const double value = next(property.type, is_face || is_place, element, k);
                if (list) corners_.push_back(value >= 0 && value < ~Corner(0) ? static_cast<Corner>(value) : ~Corner(0));
                else if (is_place) x[property.name[0] - 'x'] = value, mesh_.single |= binary_ && property.type == 'f';
            }
            if (!is_face || corners_.size() < 3) continue;
            mesh_.corner.insert(mesh_.corner.end(), corners_.begin(), corners_.end());
            mesh_.end.push_back(mesh_.corner.size());
        }
        if (!is_vertex) return;
        if (!x.cast<float>().allFinite()) words_.fail(fmt::format("vertex {} is not finite in single precision", k));
        mesh_.position.push_back(x);
    }

    const std::string& file_;
    Words words_;
    std::vector<PlyElement> elements_;
    bool binary_ = false, swapped_ = false;
    std::string_view bytes_;
    std::vector<Corner> corners_;
    Polygons mesh_;
};

}  // namespace

Polygons read_ply(const std::string& file, std::string_view text) { return PlyReader(file, text).read(); }

}  // namespace whorl
