#pragma once
/// JSON whose values store their location in the file, and whether they were read.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/errors.h"
#include "engine/core/types.h"

namespace whorl {

struct JsonNode {
    nlohmann::json value;           ///< of a list or object without its entries
    std::vector<JsonNode> entries;  ///< of a list, or of an object: these have names
    std::string name, path;         ///< "viscosity", "Materials[0].viscosity"
    FileLocation place;             ///< of an object's entry its key's
    mutable bool used = false;      ///< it was read

    /// Value of the member; empty if it is absent. @throws InputError at its location if it has another type
    std::optional<double> number_of(const std::string& key) const;
    std::optional<bool> truth_of(const std::string& key) const;
    std::optional<std::string> text_of(const std::string& key) const;
    std::optional<Vec3d> vector_of(const std::string& key) const;
    /// Objects of a member that is a list of objects; empty if it is absent.
    std::vector<const JsonNode*> objects_of(const std::string& key) const;
    /// The member; null if it is absent.
    const JsonNode* find(const std::string& key) const;
    /// Calls f(node) for the values that were not read, in the file's order; once for a list or object
    /// of which nothing was read.
    template <class F>
    void each_unused(F&& f) const {
        if (!used) return f(*this);
        for (const JsonNode& entry : entries) entry.each_unused(f);
    }
};

/// @throws InputError with file, line and column where it cannot be read or is no JSON; comments are passed over
JsonNode read_json(const std::filesystem::path& file);

}  // namespace whorl
