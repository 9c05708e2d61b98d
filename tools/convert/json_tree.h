#pragma once
/// JSON tree whose nodes store their location in the file, and whether they were read.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/errors.h"
#include "engine/core/types.h"

namespace whorl {

struct JsonNode {
    nlohmann::json value;           ///< a list or object is stored without its entries
    std::vector<JsonNode> entries;  ///< of a list or object; those of an object have names
    std::string name, path;         ///< "viscosity", "Materials[0].viscosity"
    FileLocation place;             ///< of the value, or of the key if the node is an entry of an object
    mutable bool used = false;      ///< whether the node was read

    /// Value of the member; empty if it is absent. @throws InputError at its location if it has another type
    std::optional<double> number_of(const std::string& key) const;
    std::optional<bool> truth_of(const std::string& key) const;
    std::optional<std::string> text_of(const std::string& key) const;
    std::optional<Vec3d> vector_of(const std::string& key) const;
    /// Objects of a member that is a list of objects; empty if it is absent.
    std::vector<const JsonNode*> objects_of(const std::string& key) const;
    /// The member; null if it is absent.
    const JsonNode* find(const std::string& key) const;
    /// Calls f(node) for the values that were not read, in the order of the file. A list or object of which nothing was read counts as one
    /// value.
    template <class F>
    void each_unused(F&& f) const {
        if (!used) return f(*this);
        for (const JsonNode& entry : entries) entry.each_unused(f);
    }
};

/// Reads a JSON object; comments are allowed. @throws InputError with file, line and column if the file cannot be read or is invalid
JsonNode read_json(const std::filesystem::path& file);

}  // namespace whorl
