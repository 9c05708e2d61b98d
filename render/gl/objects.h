#pragma once
/// OpenGL objects that free themselves. Only .cpp files of render/gl include this.
#include <epoxy/gl.h>

#include <initializer_list>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/types.h"

namespace whorl {
/// A file of render/shaders, embedded at build time. @param name "liquid.frag" @throws std::logic_error if it does not exist
std::string shader_source(const std::string& name);
}  // namespace whorl

namespace whorl::gl {

/// Owner of a GL object: deletes it by its GL name.
template <void (*Delete)(GLuint)>
class Name {
public:
    Name() = default;
    explicit Name(GLuint id) : id_(id) {}
    Name(Name&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
    Name& operator=(Name&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    ~Name() {
        if (id_ != 0) Delete(id_);
    }
    GLuint id() const { return id_; }

private:
    GLuint id_ = 0;
};

inline void delete_texture(GLuint id) { glDeleteTextures(1, &id); }
inline void delete_buffer(GLuint id) { glDeleteBuffers(1, &id); }
inline void delete_vertex_array(GLuint id) { glDeleteVertexArrays(1, &id); }
inline void delete_framebuffer(GLuint id) { glDeleteFramebuffers(1, &id); }
inline void delete_program(GLuint id) { glDeleteProgram(id); }

using Texture = Name<delete_texture>;
using Buffer = Name<delete_buffer>;
using VertexArray = Name<delete_vertex_array>;
using Framebuffer = Name<delete_framebuffer>;

/// A texture of `format`, clamped at its edges. @param linear interpolates; otherwise the nearest texel
Texture texture_2d(GLenum format, int width, int height, bool linear);
/// Fills a 3D texture with one or four floats per texel, interpolated linearly and clamped at its edges. Creates the texture if needed.
void fill_3d(Texture& texture, int nx, int ny, int nz, const float* value, int channels = 1);
/// A framebuffer with these colour textures and with this depth and stencil texture (0: none).
Framebuffer framebuffer(std::initializer_list<GLuint> colours, GLuint depth);
/// Directs the following draws to all pixels of a framebuffer.
void draw_into(const Framebuffer& target, int width, int height);

/// Draws the triangle of screen.vert, which covers the viewport, with the current program.
void draw_screen();
/// GLSL declaration of a constant.
std::string constant(const char* name, bool value);
std::string constant(const char* name, int value);

/// A linked program. Uniforms are set by name; a uniform that the compiler has removed is ignored.
class Program {
public:
    /// Compiles each stage from embedded files, joined in order after the #version line.
    /// @param constants declarations placed before the fragment files
    /// @throws std::logic_error with the compiler's log
    Program(const std::vector<const char*>& vertex_files, const std::vector<const char*>& fragment_files,
            const std::string& constants = "");
    void use() const { glUseProgram(name_.id()); }
    void set(const char* uniform, int value);
    void set(const char* uniform, float value);
    void set(const char* uniform, const Eigen::Vector2f& value);
    void set(const char* uniform, const Vec3f& value);
    void set(const char* uniform, const Eigen::Vector4f& value);
    void set(const char* uniform, const Mat3f& value);
    void set(const char* uniform, const std::vector<Eigen::Vector4f>& values);  ///< the first values.size() elements of an array
    void set(const char* uniform, const std::vector<Eigen::Matrix4f>& values);
    void set(const char* uniform, const Eigen::Matrix4f& value);
    /// Binds a texture to a texture unit, from which the sampler `uniform` then reads.
    void texture(const char* uniform, int unit, GLenum target, GLuint id);

private:
    GLint location(const char* uniform);
    Name<delete_program> name_;
    std::map<std::string, GLint> locations_;
};

/// Variants of a program, one for each set of constants, compiled at first use. The software driver runs both sides of a branch unless its
/// condition is constant.
class Programs {
public:
    Programs(std::vector<const char*> vertex_files, std::vector<const char*> fragment_files)
        : vertex_files_(std::move(vertex_files)), fragment_files_(std::move(fragment_files)) {}
    Program& with(const std::string& constants) {
        return made_.try_emplace(constants, vertex_files_, fragment_files_, constants).first->second;
    }

private:
    std::vector<const char*> vertex_files_, fragment_files_;
    std::map<std::string, Program> made_;
};

/// Triangles or points in graphics memory. Attribute i has components[i] floats per vertex.
class Vertices {
public:
    Vertices(const std::vector<int>& components);
    /// Stores one array of floats per attribute, in order. `indices` may be null: vertices are then drawn in order.
    void fill(std::initializer_list<std::pair<const float*, std::size_t>> attributes, const std::uint32_t* indices,
              std::size_t index_count);
    void draw(GLenum primitive) const;
    std::size_t count() const { return count_; }

private:
    VertexArray array_;
    std::vector<Buffer> attributes_;
    std::vector<int> components_;
    Buffer indices_;
    std::size_t count_ = 0;
    bool indexed_ = false;
};

/// An attribute of three floats per vertex.
inline std::pair<const float*, std::size_t> numbers(const std::vector<Vec3f>& v) {
    return {v.empty() ? nullptr : v[0].data(), 3 * v.size()};
}

}  // namespace whorl::gl
