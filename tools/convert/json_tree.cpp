#include "tools/convert/json_tree.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

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

    CountingIterator(const char* at, Place* place) : at_(at), place_(place) {}
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
    Place* place_;
};

/// Builds the tree from the parser's events.
struct TreeBuilder {
    const Place& now;
    JsonNode root;
    std::vector<JsonNode*> open;
    std::string newest_key;
    Place key_place;

    JsonNode& add(JsonNode::Kind kind) {
        JsonNode node;
        node.kind = kind;
        node.place = now;
        if (kind == JsonNode::Kind::object || kind == JsonNode::Kind::list) --node.place.column;  // of its bracket
        if (open.empty()) return root = std::move(node);
        JsonNode& parent = *open.back();
        if (parent.kind == JsonNode::Kind::list) {
            node.path = fmt::format("{}[{}]", parent.path, parent.list.size());
            return parent.list.emplace_back(std::move(node));
        }
        node.path = parent.path.empty() ? newest_key : parent.path + "." + newest_key;
        node.place = key_place;
        node.name = newest_key;
        return parent.members.emplace_back(std::move(node));
    }
    bool add_number(double value) { return add(JsonNode::Kind::number).number = value, true; }

    bool start(JsonNode::Kind kind) {
        constexpr std::size_t deepest = 100;  // each level takes its part of the stack when the tree goes
        if (open.size() >= deepest)
            throw InputError({now.file, now.line, now.column - 1}, "more than 100 brackets are open", "", "a scene file in JSON");
        open.push_back(&add(kind));
        return true;
    }

    bool null() { return add(JsonNode::Kind::nothing), true; }
    bool boolean(bool value) { return add(JsonNode::Kind::truth).truth = value, true; }
    bool number_integer(std::int64_t value) { return add_number(static_cast<double>(value)); }
    bool number_unsigned(std::uint64_t value) { return add_number(static_cast<double>(value)); }
    bool number_float(double value, const std::string&) { return add_number(value); }
    bool string(std::string& value) { return add(JsonNode::Kind::text).text = value, true; }
    bool binary(nlohmann::json::binary_t&) { return false; }
    bool start_object(std::size_t) { return start(JsonNode::Kind::object); }
    bool start_array(std::size_t) { return start(JsonNode::Kind::list); }
    bool end_object() { return open.pop_back(), true; }
    bool end_array() { return open.pop_back(), true; }
    bool key(const std::string& name) {
        newest_key = name, key_place = now;
        key_place.column = std::max(1, key_place.column - static_cast<int>(name.size()) - 2);  // its opening quote
        return true;
    }
    bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& error) {
        // "[json.exception.parse_error.101] parse error at line 3, column 5: syntax error while ...": the place is known better here.
        std::string what = error.what();
        if (const std::size_t colon = what.find(": "); colon != std::string::npos) what = what.substr(colon + 2);
        throw InputError(now, what, "", "a scene file in JSON");
    }
};

[[noreturn]] void wrong_kind(const JsonNode& node, const char* wanted) {
    throw InputError(node.place, node.path + " is not " + wanted, "", std::string("allowed: ") + wanted);
}

}  // namespace

const JsonNode* JsonNode::find(const std::string& key) const {
    used = true;
    for (const JsonNode& node : members)
        if (node.name == key) {
            node.used = true;
            return &node;
        }
    return nullptr;
}

std::optional<double> JsonNode::number_of(const std::string& key) const {
    const JsonNode* node = find(key);
    if (!node) return {};
    if (node->kind != Kind::number) wrong_kind(*node, "a number");
    return node->number;
}

std::optional<bool> JsonNode::truth_of(const std::string& key) const {
    const JsonNode* node = find(key);
    if (!node) return {};
    if (node->kind == Kind::number) return node->number != 0;
    if (node->kind != Kind::truth) wrong_kind(*node, "true or false");
    return node->truth;
}

std::optional<std::string> JsonNode::text_of(const std::string& key) const {
    const JsonNode* node = find(key);
    if (!node) return {};
    if (node->kind != Kind::text) wrong_kind(*node, "a text");
    return node->text;
}

std::optional<Vec3d> JsonNode::vector_of(const std::string& key) const {
    const JsonNode* node = find(key);
    if (!node) return {};
    if (node->kind == Kind::number) return Vec3d(Vec3d::Constant(node->number));  // a scale of all axes
    if (node->kind != Kind::list || node->list.size() != 3) wrong_kind(*node, "a list of three numbers");
    Vec3d vector;
    for (int a = 0; a < 3; ++a) {
        const JsonNode& one = node->list[static_cast<std::size_t>(a)];
        one.used = true;
        if (one.kind != Kind::number) wrong_kind(one, "a number");
        vector[a] = one.number;
    }
    return vector;
}

std::vector<const JsonNode*> JsonNode::objects_of(const std::string& key) const {
    const JsonNode* node = find(key);
    std::vector<const JsonNode*> objects;
    if (!node) return objects;
    if (node->kind != Kind::list) wrong_kind(*node, "a list");
    for (const JsonNode& one : node->list) {
        if (one.kind != Kind::object) wrong_kind(one, "an object");
        one.used = true;
        objects.push_back(&one);
    }
    return objects;
}

JsonNode read_json(const std::filesystem::path& file) {
    const std::string text = read_whole(file);
    Place place{file.string(), 1, 1};
    TreeBuilder sax{place, {}, {}, {}, {}};
    const CountingIterator begin(text.data(), &place), end(text.data() + text.size(), &place);
    nlohmann::json::sax_parse(begin, end, &sax, nlohmann::json::input_format_t::json, true, true);
    if (sax.root.kind != JsonNode::Kind::object) throw InputError({file.string(), 1, 1}, "is not a scene", "", "a JSON object");
    return std::move(sax.root);
}

}  // namespace whorl
