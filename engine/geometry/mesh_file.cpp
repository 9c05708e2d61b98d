#include "engine/geometry/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <fstream>
#include <functional>
#include <numeric>
#include <span>
#include <sstream>

#include "engine/core/errors.h"
#include "engine/geometry/mesh_text.h"

namespace whorl {
namespace {

Polygons read_obj(const std::string& file, std::string_view text) {
    Polygons mesh;
    Words words(file, text, true);
    while (words.next_line()) {
        const std::string_view key = words.word();
        if (key == "v") mesh.position.push_back(words.point());
        if (key != "f") continue;
        const std::size_t begin = mesh.corner.size();
        for (std::string_view corner = words.word(); !corner.empty() && corner[0] != '#'; corner = words.word()) {
            const long long count = static_cast<long long>(mesh.position.size());
            long long index = words.whole<long long>(corner.substr(0, corner.find('/')));
            if (index < 0) index += count + 1;  // counted from the last vertex
            if (index < 1 || index > count)
                words.fail(fmt::format("face refers to vertex {}, only {} are defined before it", corner, count));
            mesh.corner.push_back(static_cast<Corner>(index - 1));
        }
        if (mesh.corner.size() < begin + 3) words.fail("a face needs at least three vertices");
        mesh.end.push_back(mesh.corner.size());
    }
    return mesh;
}

/// Reads word by word, because some programs write the whole file on one line. Ignores everything except corners, even normals.
Polygons read_ascii_stl(const std::string& file, std::string_view text) {
    Polygons mesh;
    Words words(file, text);
    while (words.next_line())
        for (std::string key = lower(words.word()); !key.empty(); key = lower(words.word())) {
            if (key == "solid" || key == "endsolid") words.skip_name();
            if (key == "vertex") mesh.corner.push_back(static_cast<Corner>(mesh.position.size())), mesh.position.push_back(words.point());
            if (key != "endloop") continue;
            const std::size_t count = mesh.corner.size() - 3 * mesh.end.size();
            if (count != 3) words.fail(fmt::format("a facet has {} vertices", count));
            mesh.end.push_back(mesh.corner.size());
        }
    if (mesh.corner.size() > 3 * mesh.end.size()) words.fail("the file ends inside a facet");
    return mesh;
}

Polygons read_binary_stl(const std::string& file, std::string_view text) {
    const std::size_t count = bytes_as<std::uint32_t>(text.data() + 80);
    if (text.size() < 84 + 50 * count)
        throw InputError({file}, fmt::format("the file is cut short: its header announces {} triangles, it contains {}", count,
                                             (text.size() - 84) / 50));
    Polygons mesh;
    mesh.single = true;
    for (std::size_t k = 0; k < 3 * count; ++k) {
        const char* bytes = text.data() + 84 + 50 * (k / 3) + 12 + 12 * (k % 3);
        mesh.position.emplace_back(bytes_as<float>(bytes), bytes_as<float>(bytes + 4), bytes_as<float>(bytes + 8));
        if (!mesh.position.back().allFinite())
            throw InputError({file}, fmt::format("a coordinate of triangle {} is not finite", k / 3 + 1));
        mesh.corner.push_back(static_cast<Corner>(k));
        if (k % 3 == 2) mesh.end.push_back(k + 1);
    }
    return mesh;
}

/// Reads glTF with assimp. The other formats have their own readers, because those of assimp are not reliable: its OBJ reader
/// skips lines that it does not understand and ends a number at a decimal comma. Its STL reader requires valid normals and lower case. On
/// 2000 damaged PLY files, its PLY reader crashes 432 times and never ends 391 times.
/// With a node, reads only the meshes of that node and its children, in its axes.
Polygons read_gltf(const std::string& file, const std::string& node) {
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(file, node.empty() ? unsigned{aiProcess_PreTransformVertices} : 0u);
    if (!scene) throw InputError({file}, fmt::format("cannot be read: {}", importer.GetErrorString()));
    Polygons mesh;
    mesh.single = true;
    const auto add = [&](const aiMesh* part, const aiMatrix4x4& place) {
        const Corner first = static_cast<Corner>(mesh.position.size());
        for (const aiVector3D& own : std::span(part->mVertices, part->mNumVertices)) {
            const aiVector3D x = place * own;
            mesh.position.emplace_back(x.x, x.y, x.z);
            if (!mesh.position.back().allFinite())
                throw InputError({file}, fmt::format("a coordinate of vertex {} is not finite", mesh.position.size()));
        }
        for (const aiFace& face : std::span(part->mFaces, part->mNumFaces)) {
            if (face.mNumIndices < 3) continue;  // points and lines
            for (const unsigned corner : std::span(face.mIndices, face.mNumIndices)) mesh.corner.push_back(first + corner);
            mesh.end.push_back(mesh.corner.size());
        }
    };
    if (node.empty()) {
        for (const aiMesh* part : std::span(scene->mMeshes, scene->mNumMeshes)) add(part, {});
        return mesh;
    }
    const aiNode* top = scene->mRootNode->FindNode(node.c_str());
    if (!top) throw InputError({file}, fmt::format("has no node \"{}\"", node));
    const std::function<void(const aiNode&, const aiMatrix4x4&)> add_all = [&](const aiNode& one, const aiMatrix4x4& place) {
        for (const unsigned k : std::span(one.mMeshes, one.mNumMeshes)) add(scene->mMeshes[k], place);
        for (const aiNode* child : std::span(one.mChildren, one.mNumChildren)) add_all(*child, place * child->mTransformation);
    };
    add_all(*top, {});
    return mesh;
}

}  // namespace

void triangulate(const std::vector<Vec3d>& x, std::vector<Corner> ring, std::vector<std::array<Corner, 3>>& to) {
    Vec3d normal = Vec3d::Zero();
    for (std::size_t k = 2; k < ring.size(); ++k) normal += (x[ring[k - 1]] - x[ring[0]]).cross(x[ring[k]] - x[ring[0]]);
    const auto turn = [&](Corner a, Corner b, Corner c) { return normal.dot((x[b] - x[a]).cross(x[c] - x[a])); };
    long tests = 0;
    const auto is_ear = [&](std::size_t k, double least) {
        const Corner a = ring[k - 1], b = ring[k], c = ring[(k + 1) % ring.size()];
        return turn(a, b, c) > least && std::none_of(ring.begin(), ring.end(), [&](Corner p) {
                   return ++tests < 100'000'000 && x[p] != x[a] && x[p] != x[b] && x[p] != x[c] && turn(a, b, p) >= 0 &&
                          turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
               });
    };
    while (ring.size() > 3) {
        std::size_t ear = 0;
        for (const double least : {1e-6 * normal.squaredNorm(), 0.0})  // slivers last
            for (std::size_t k = 1; k < ring.size() && ear == 0; ++k)
                if (is_ear(k, least)) ear = k;
        ear = std::max<std::size_t>(ear, 1);
        to.push_back({ring[ear - 1], ring[ear], ring[(ear + 1) % ring.size()]});
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    to.push_back({ring[0], ring[1], ring[2]});
}

void weld(TriangleMesh& mesh) {
    std::vector<Corner> order(mesh.position.size()), to(mesh.position.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto compare = [&](Corner a, Corner b) {
        const Vec3f &x = mesh.position[a], &y = mesh.position[b];
        return std::tuple(x[0], x[1], x[2]) <=> std::tuple(y[0], y[1], y[2]);
    };
    std::sort(order.begin(), order.end(), [&](Corner a, Corner b) {
        const auto way = compare(a, b);
        return way < 0 || (way == 0 && a < b);
    });
    for (std::size_t k = 0; k < order.size(); ++k)
        to[order[k]] = k > 0 && compare(order[k], order[k - 1]) == 0 ? to[order[k - 1]] : order[k];
    TriangleMesh welded;
    for (Corner k = 0; k < to.size(); ++k) {
        if (to[k] == k) to[k] = static_cast<Corner>(welded.position.size()), welded.position.push_back(mesh.position[k]);
        else to[k] = to[to[k]];
    }
    for (const auto& t : mesh.triangle) {
        const std::array<Corner, 3> corner{to[t[0]], to[t[1]], to[t[2]]};
        if (corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0]) welded.triangle.push_back(corner);
    }
    mesh = std::move(welded);
}

TriangleMesh read_mesh(const std::filesystem::path& file, double scale, const Vec3d& position, const std::string& node) {
    const std::string name = file.string(), kind = lower(file.extension().string());
    std::ifstream in(file, std::ios::binary);
    std::error_code none;
    if (!in || !std::filesystem::is_regular_file(file, none)) throw InputError({name}, "the mesh file cannot be opened");
    std::stringstream buffer;
    buffer << in.rdbuf();
    const std::string bytes = buffer.str();
    std::string_view text = bytes;
    // Binary STL files may also begin with "solid". Unlike text, a binary file has a zero byte in its header or triangle count, or is long
    // enough for that many triangles.
    const bool binary = text.size() >= 84 && (text.substr(0, 84).find('\0') != text.npos ||
                                              text.size() >= 84 + 50 * std::size_t(bytes_as<std::uint32_t>(text.data() + 80)));
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // a byte-order mark
    Polygons read;
    if (kind == ".obj") read = read_obj(name, text);
    else if (kind == ".ply") read = read_ply(name, text);
    else if (kind == ".stl") read = binary ? read_binary_stl(name, bytes) : read_ascii_stl(name, text);
    else if (kind == ".gltf" || kind == ".glb") read = read_gltf(name, node);
    else throw InputError({name}, "\"" + kind + "\" is not a kind of mesh file", "", ".obj, .ply, .stl, .gltf, .glb");
    if (read.end.empty()) throw InputError({name}, "the file contains no triangles");
    for (const Corner c : read.corner)
        if (c >= read.position.size())
            throw InputError(
                {name}, fmt::format("a face refers to a missing vertex; the file has {} vertices, counted from 0", read.position.size()));

    TriangleMesh mesh;
    for (std::size_t k = 0, begin = 0; k < read.end.size(); begin = read.end[k++])
        triangulate(
            read.position,
            {read.corner.begin() + static_cast<std::ptrdiff_t>(begin), read.corner.begin() + static_cast<std::ptrdiff_t>(read.end[k])},
            mesh.triangle);
    Eigen::AlignedBox3d raw, box;
    for (const Vec3d& x : read.position) {
        raw.extend(x), box.extend(scale * x + position);
        mesh.position.push_back((scale * x + position).cast<float>());
    }
    const auto most = [](const Eigen::AlignedBox3d& b) { return b.min().cwiseAbs().cwiseMax(b.max().cwiseAbs()).maxCoeff(); };
    const double far = std::max(most(box), read.single ? scale * most(raw) : 0), size = box.diagonal().norm();
    if (!(far * 0x1p-24 <= 1e-3 * size))
        throw InputError(
            {name},
            fmt::format("single precision rounds positions {:.3g} m from the origin to {:.2g} m, too coarse for a mesh {:.3g} m "
                        "long",
                        far, far * 0x1p-23, size),
            "move the mesh to the origin in a mesh editor");
    return mesh;
}

}  // namespace whorl
