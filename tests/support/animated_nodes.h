#pragma once
/// glTF files with animated nodes, for tests.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace whorl::test {

struct AnimatedNodes {
    nlohmann::json json;  ///< the file's JSON, without its buffer

    /// Adds a node. @param more further properties of the node @return its index
    int node(const std::string& name, const nlohmann::json& more = nlohmann::json::object());
    /// Adds an animation of a node's "translation", "rotation" or "scale". @param values three or four per key; CUBICSPLINE: in-tangent,
    /// value, out-tangent of each key
    void track(int node, const std::string& path, const std::vector<float>& times, const std::vector<float>& values,
               const std::string& interpolation = "LINEAR");
    void write(const std::filesystem::path& glb) const;

private:
    std::string binary_;
    int accessor(const std::vector<float>& numbers, int width);
};

/// A node "name" at `position`, whose parent "rig" turns about y at the rate w [rad/s] from 0 to `end` [s].
AnimatedNodes turning_node(const std::string& name, double w, double end, const std::vector<double>& position = {0, 0, 0});

}  // namespace whorl::test
