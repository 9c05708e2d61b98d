#include "render/gl/objects.h"

#include <stdexcept>

#include "engine/core/errors.h"

namespace whorl::gl {
namespace {

GLuint made(void (*generate)(GLsizei, GLuint*)) {
    GLuint id = 0;
    generate(1, &id);
    return id;
}

GLuint compiled(GLenum stage, const std::vector<const char*>& files, const std::string& constants) {
    std::string source = "#version 330 core\n" + constants, names;
    for (const char* file : files) {
        source += shader_source(file) + "\n";
        names += std::string(" ") + file;
    }
    const GLuint shader = glCreateShader(stage);
    const char* text = source.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint compiles = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiles);
    if (compiles != 0) return shader;
    std::string log(4096, '\0');
    GLsizei length = 0;
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
    glDeleteShader(shader);
    throw std::logic_error("shader" + names + " does not compile:\n" + log.substr(0, length));
}

}  // namespace

Texture texture_2d(GLenum format, int width, int height, bool linear) {
    Texture texture(made(glGenTextures));
    glBindTexture(GL_TEXTURE_2D, texture.id());
    const bool depth = format == GL_DEPTH24_STENCIL8;
    glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), width, height, 0, depth ? GL_DEPTH_STENCIL : GL_RGBA,
                 depth ? GL_UNSIGNED_INT_24_8 : GL_FLOAT, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, linear ? GL_LINEAR : GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, linear ? GL_LINEAR : GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

void fill_3d(Texture& texture, int nx, int ny, int nz, const float* value, int channels) {
    if (texture.id() == 0) {
        texture = Texture(made(glGenTextures));
        glBindTexture(GL_TEXTURE_3D, texture.id());
        for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) glTexParameteri(GL_TEXTURE_3D, filter, GL_LINEAR);
        for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
            glTexParameteri(GL_TEXTURE_3D, axis, GL_CLAMP_TO_EDGE);
    }
    glBindTexture(GL_TEXTURE_3D, texture.id());
    const bool one = channels == 1;
    glTexImage3D(GL_TEXTURE_3D, 0, one ? GL_R32F : GL_RGBA16F, nx, ny, nz, 0, one ? GL_RED : GL_RGBA, GL_FLOAT, value);
}

Framebuffer framebuffer(std::initializer_list<GLuint> colours, GLuint depth) {
    Framebuffer target(made(glGenFramebuffers));
    glBindFramebuffer(GL_FRAMEBUFFER, target.id());
    std::vector<GLenum> attachments;
    for (const GLuint colour : colours) {
        attachments.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachments.size()));
        glFramebufferTexture2D(GL_FRAMEBUFFER, attachments.back(), GL_TEXTURE_2D, colour, 0);
    }
    if (depth != 0) glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
    glDrawBuffers(static_cast<GLsizei>(attachments.size()), attachments.data());
    const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    WHORL_ASSERT(status == GL_FRAMEBUFFER_COMPLETE, "status " + std::to_string(status));
    return target;
}

void draw_into(const Framebuffer& target, int width, int height) {
    glBindFramebuffer(GL_FRAMEBUFFER, target.id());
    glViewport(0, 0, width, height);
}

void draw_screen() {
    const VertexArray no_vertices(made(glGenVertexArrays));
    glBindVertexArray(no_vertices.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

std::string constant(const char* name, bool value) {
    return std::string("const bool ") + name + " = " + (value ? "true" : "false") + ";\n";
}
std::string constant(const char* name, int value) { return std::string("const int ") + name + " = " + std::to_string(value) + ";\n"; }

Program::Program(const std::vector<const char*>& vertex_files, const std::vector<const char*>& fragment_files, const std::string& constants)
    : name_(glCreateProgram()) {
    for (const GLuint shader : {compiled(GL_VERTEX_SHADER, vertex_files, ""), compiled(GL_FRAGMENT_SHADER, fragment_files, constants)}) {
        glAttachShader(name_.id(), shader);
        glDeleteShader(shader);
    }
    glLinkProgram(name_.id());
    GLint links = 0;
    glGetProgramiv(name_.id(), GL_LINK_STATUS, &links);
    if (links != 0) return;
    std::string log(4096, '\0');
    glGetProgramInfoLog(name_.id(), static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw std::logic_error("shader program does not link:\n" + log);
}

GLint Program::location(const char* uniform) {
    const auto [place, is_new] = locations_.try_emplace(uniform, -1);
    if (is_new) place->second = glGetUniformLocation(name_.id(), uniform);
    return place->second;
}
void Program::set(const char* uniform, int value) { glUniform1i(location(uniform), value); }
void Program::set(const char* uniform, float value) { glUniform1f(location(uniform), value); }
void Program::set(const char* uniform, const Eigen::Vector2f& value) { glUniform2fv(location(uniform), 1, value.data()); }
void Program::set(const char* uniform, const Vec3f& value) { glUniform3fv(location(uniform), 1, value.data()); }
void Program::set(const char* uniform, const Eigen::Vector4f& value) { glUniform4fv(location(uniform), 1, value.data()); }
void Program::set(const char* uniform, const std::vector<Eigen::Vector4f>& values) {
    if (!values.empty()) glUniform4fv(location(uniform), static_cast<GLsizei>(values.size()), values[0].data());
}
void Program::set(const char* uniform, const std::vector<Eigen::Matrix4f>& values) {
    if (!values.empty()) glUniformMatrix4fv(location(uniform), static_cast<GLsizei>(values.size()), GL_FALSE, values[0].data());
}
void Program::set(const char* uniform, const Mat3f& value) { glUniformMatrix3fv(location(uniform), 1, GL_FALSE, value.data()); }
void Program::set(const char* uniform, const Eigen::Matrix4f& value) { glUniformMatrix4fv(location(uniform), 1, GL_FALSE, value.data()); }
void Program::texture(const char* uniform, int unit, GLenum target, GLuint id) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target, id);
    set(uniform, unit);
}

Vertices::Vertices(const std::vector<int>& components)
    : array_(made(glGenVertexArrays)), components_(components), indices_(made(glGenBuffers)) {
    glBindVertexArray(array_.id());
    for (std::size_t i = 0; i < components.size(); ++i) {
        attributes_.emplace_back(made(glGenBuffers));
        glBindBuffer(GL_ARRAY_BUFFER, attributes_.back().id());
        glVertexAttribPointer(static_cast<GLuint>(i), components[i], GL_FLOAT, GL_FALSE, 0, nullptr);
        glEnableVertexAttribArray(static_cast<GLuint>(i));
    }
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.id());
}

void Vertices::fill(std::initializer_list<std::pair<const float*, std::size_t>> attributes, const std::uint32_t* indices,
                    std::size_t index_count) {
    glBindVertexArray(array_.id());
    std::size_t i = 0;
    for (const auto& [data, floats] : attributes) {
        count_ = floats / static_cast<std::size_t>(components_[i]);
        glBindBuffer(GL_ARRAY_BUFFER, attributes_[i++].id());
        glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(floats * sizeof(float)), data, GL_STREAM_DRAW);
    }
    indexed_ = indices != nullptr;
    if (!indexed_) return;
    count_ = index_count;
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(index_count * sizeof(std::uint32_t)), indices, GL_STREAM_DRAW);
}

void Vertices::draw(GLenum primitive) const {
    if (count_ == 0) return;
    glBindVertexArray(array_.id());
    if (indexed_) glDrawElements(primitive, static_cast<GLsizei>(count_), GL_UNSIGNED_INT, nullptr);
    else glDrawArrays(primitive, 0, static_cast<GLsizei>(count_));
}

}  // namespace whorl::gl
