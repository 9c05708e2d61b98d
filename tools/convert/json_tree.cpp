#include "tools/convert/json_tree.h"

#include <fmt/format.h>

#include "engine/io/csv.h"

namespace whorl {
namespace {

/// Reads characters one by one and counts lines: the parser reports a key or value as soon as its last character was read.
class CountingIterator {
public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    CountingIterator(const char* at, FileLocation* place) : at_(at), place_(place) {}
    const char& operator*() const { return *at_; }
    CountingIterator& operator++() {
        if (*at_ == '\n') ++place_->line, place_->column = 0;
        ++place_->column;
        ++at_;
        return *this;
    }
    CountingIterator operator++(int) {
        CountingIterator before = *this;
        ++*this;
        return before;
    }
    bool operator==(const CountingIterator& o) const { return at_ == o.at_; }
    bool operator!=(const CountingIterator& o) const { return at_ != o.at_; }

private:
    const char* at_;
    FileLocation* place_;
};

/// Builds the tree from the parser's events.
struct TreeBuilder {
    const FileLocation& now;
    JsonNode root;
    std::vector<JsonNode*> open;
    std::string newest_key;
    FileLocation key_place;

    bool add(nlohmann::json value) {
        JsonNode node{std::move(value), {}, "", "", now};
        if (node.value.is_structured()) --node.place.column;  // location of its opening bracket
        if (open.empty()) return root = std::move(node), true;
        JsonNode& parent = *open.back();
        if (parent.value.is_array()) node.path = fmt::format("{}[{}]", parent.path, parent.entries.size());
        else node.path = (parent.path.empty() ? "" : parent.path + ".") + newest_key, node.name = newest_key, node.place = key_place;
        parent.entries.push_back(std::move(node));
        return true;
    }
    bool start(nlohmann::json value) {
        constexpr std::size_t deepest = 100;  // deleting the tree recurses once per level
        if (open.size() >= deepest)
            throw InputError({now.file, now.line, now.column - 1}, "more than 100 brackets are open", "", "a scene file in JSON");
        add(std::move(value));
        open.push_back(open.empty() ? &root : &open.back()->entries.back());
        return true;
    }

    bool null() { return add(nullptr); }
    bool boolean(bool value) { return add(value); }
    bool number_integer(std::int64_t value) { return add(value); }
    bool number_unsigned(std::uint64_t value) { return add(value); }
    bool number_float(double value, const std::string&) { return add(value); }
    bool string(std::string& value) { return add(value); }
    bool binary(nlohmann::json::binary_t&) { return false; }
    bool start_object(std::size_t) { return start(nlohmann::json::object()); }
    bool start_array(std::size_t) { return start(nlohmann::json::array()); }
    bool end_object() { return open.pop_back(), true; }
    bool end_array() { return open.pop_back(), true; }
    bool key(const std::string& name) {
        newest_key = name, key_place = now;
        key_place.column = std::max(1, key_place.column - static_cast<int>(name.size()) - 2);  // its opening quote
        return true;
    }
    bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& error) {
        // Removes "[json.exception.parse_error.101] parse error at line 3, column 5: ", because `now` is the better location.
        std::string what = error.what();
        if (const std::size_t colon = what.find(": "); colon != std::string::npos) what = what.substr(colon + 2);
        throw InputError(now, what, "", "a scene file in JSON");
    }
};

void check(const JsonNode& node, bool is_right, const char* wanted) {
    if (!is_right) throw InputError(node.place, node.path + " is not " + wanted, "", std::string("allowed: ") + wanted);
}

}  // namespace

const JsonNode* JsonNode::find(const std::string& key) const {
    used = true;
    for (const JsonNode& node : entries)
        if (node.name == key) {
            node.used = true;
            return &node;
        }
    return nullptr;
}

std::optional<double> JsonNode::number_of(const std::string& key) const {
    const JsonNode* node = find(key);
    if (!node) return {};
    check(*node, node->value.is_number(), "a number");
    return node->value.get<double>();
}

std::optional<bool> JsonNode::truth_of(const std::string& key) const {
    const JsonNode* node = find(key);
    if (!node) return {};
    if (node->value.is_number()) return node->value.get<double>() != 0;
    check(*node, node->value.is_boolean(), "true or false");
    return node->value.get<bool>();
}

std::optional<std::string> JsonNode::text_of(const std::string& key) const {
    const JsonNode* node = find(key);
    if (!node) return {};
    check(*node, node->value.is_string(), "a string");
    return node->value.get<std::string>();
}

std::optional<Vec3d> JsonNode::vector_of(const std::string& key) const {
    const JsonNode* node = find(key);
    if (!node) return {};
    if (node->value.is_number()) return Vec3d(Vec3d::Constant(node->value.get<double>()));  // the same scale for all axes
    check(*node, node->value.is_array() && node->entries.size() == 3, "a list of three numbers");
    Vec3d vector;
    for (std::size_t a = 0; a < 3; ++a) {
        const JsonNode& entry = node->entries[a];
        entry.used = true;
        check(entry, entry.value.is_number(), "a number");
        vector[static_cast<Eigen::Index>(a)] = entry.value.get<double>();
    }
    return vector;
}

std::vector<const JsonNode*> JsonNode::objects_of(const std::string& key) const {
    std::vector<const JsonNode*> objects;
    const JsonNode* node = find(key);
    if (!node) return objects;
    check(*node, node->value.is_array(), "a list");
    for (const JsonNode& entry : node->entries) {
        check(entry, entry.value.is_object(), "an object");
        entry.used = true;
        objects.push_back(&entry);
    }
    return objects;
}

JsonNode read_json(const std::filesystem::path& file) {
    const std::string text = read_whole(file);
    FileLocation place{file.string(), 1, 1};
    TreeBuilder sax{place, {}, {}, {}, {}};
    const CountingIterator begin(text.data(), &place), end(text.data() + text.size(), &place);
    nlohmann::json::sax_parse(begin, end, &sax, nlohmann::json::input_format_t::json, true, true);
    if (!sax.root.value.is_object()) throw InputError({file.string(), 1, 1}, "is not a scene", "", "a JSON object");
    return std::move(sax.root);
}

}  // namespace whorl
