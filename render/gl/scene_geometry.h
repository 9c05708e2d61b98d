#pragma once
/// The geometry of a frame in the memory of the graphics device: the fluid and the solids.
#include <functional>
#include <map>
#include <memory>

#include "render/gl/objects.h"
#include "render/gl/setup.h"

namespace whorl {

class SceneGeometry {
public:
    void fill(const Frame& frame, const Surface& surface);
    /// The fluid as its particles, each with a colour. @param fluid bounds
    void fill(const Frame& frame, const std::vector<Vec3f>& colour, const Bounds& fluid);
    /// The fluid only as its bounds: others draw it, and it throws no shadow.
    void fill(const Frame& frame, const Bounds& fluid) { fill(frame, Shape::none, fluid); }
    /// Draws everything `moment` [s] after the frame's time, at constant velocities.
    void go_to(float moment) { moment_ = moment; }
    /// Draws with a program of mesh.vert, its view_projection already set; particles as points.
    void draw_fluid(gl::Program& program) const;
    bool are_particles() const { return shape_ == Shape::particles; }
    /// `prepare` sets the program's uniforms for each solid that is `wanted`.
    void draw_solids(gl::Program& program, bool containers, const std::function<void(const FrameSolid&)>& prepare,
                     const std::function<bool(const FrameSolid&)>& wanted = {}) const;
    /// The edges of containers, as strips as wide as the program of edge.vert makes them.
    void draw_edges(gl::Program& program) const;
    /// Draws the surface and the solids with a program of layers.vert, each with its number (render/image/exr.h).
    /// @param interval s, until the next picture @param tolerance m, of the fluid's cut at the ground
    void draw_numbered(gl::Program& program, float interval, float tolerance) const;
    bool any_solids() const { return !solids_.empty(); }
    bool any_containers() const { return !containers_.empty(); }
    const Bounds& fluid_bounds() const { return fluid_bounds_; }
    /// Bounds of the fluid and of all solids except the ground; of the domain if there are none.
    const Bounds& bounds() const { return bounds_; }

private:
    struct Model {
        std::shared_ptr<const TriangleMesh> mesh;  ///< held so that no other mesh gets its address, which is its name here
        gl::Vertices vertices{{3, 3}}, edges{{3, 3, 1}};
        float size = 0;  ///< m, of its bounds
    };
    struct Placed {
        FrameSolid solid;
        const Model* model;
        int number;  ///< its place in the frame, from 0
    };
    enum class Shape { none, surface, particles };
    /// The solids, and the bounds.
    void fill(const Frame& frame, Shape shape, const Bounds& fluid);
    const Model& model(const std::shared_ptr<const TriangleMesh>& mesh);

    gl::Vertices fluid_{{3, 3, 1, 4, 3}}, particles_{{3, 3}};
    Shape shape_ = Shape::surface;
    float moment_ = 0;  ///< s
    std::map<const TriangleMesh*, Model> models_;
    std::vector<Placed> solids_, containers_;
    Bounds fluid_bounds_, bounds_;
};

}  // namespace whorl
