#pragma once
/// Geometry of a frame in graphics memory: the fluid and the solids.
#include <functional>
#include <map>
#include <memory>

#include "render/gl/objects.h"
#include "render/gl/setup.h"

namespace whorl {

class SceneGeometry {
public:
    /// Fills in the solids, and the fluid as its surface.
    void fill(const Frame& frame, const Surface& surface);
    /// Fills in the solids, and the fluid as particles, each with a colour. @param fluid bounds of the fluid
    void fill(const Frame& frame, const std::vector<Vec3f>& colour, const Bounds& fluid);
    /// Fills in the solids, and the fluid only as its bounds: the caller draws the fluid, which casts no shadow.
    void fill(const Frame& frame, const Bounds& fluid) { fill(frame, Shape::none, fluid); }
    /// Sets the moment to draw [s after the frame's time]; everything moves at constant velocity.
    void go_to(float moment) { moment_ = moment; }
    /// Draws the fluid with a program of mesh.vert whose view_projection is set; particles are drawn as points.
    void draw_fluid(gl::Program& program) const;
    /// Sets the uniforms of crust.glsl; uses one texture unit.
    void bind_crust(gl::Program& program, int unit) const;
    bool are_particles() const { return shape_ == Shape::particles; }
    /// Draws the containers or the opaque solids, those that are `wanted` (default: all). `prepare` sets the program's uniforms for each.
    void draw_solids(gl::Program& program, bool containers, const std::function<void(const FrameSolid&)>& prepare,
                     const std::function<bool(const FrameSolid&)>& wanted = {}) const;
    /// Draws the edges of containers as strips; edge.vert sets their width.
    void draw_edges(gl::Program& program) const;
    /// Draws the surface and the solids with a program of layers.vert, each with its number (render/image/exr.h).
    /// @param interval time until the next image [s] @param tolerance the fluid is cut this far below the ground [m]
    void draw_numbered(gl::Program& program, float interval, float tolerance) const;
    /// Draws the solids that refract.
    void draw_glass(gl::Program& program, const std::function<void(const FrameSolid&)>& prepare) const;
    /// Whether the solid's mesh has texture coordinates.
    bool has_places(const FrameSolid& solid) const { return models_.at(solid.mesh.get()).has_places; }
    bool any_glass() const { return !glass_.empty(); }
    bool any_solids() const { return !solids_.empty(); }
    bool any_containers() const { return !containers_.empty(); }
    const Bounds& fluid_bounds() const { return fluid_bounds_; }
    /// Bounds of the fluid and of all solids except the ground; of the domain if there are none.
    const Bounds& bounds() const { return bounds_; }

private:
    struct Model {
        std::shared_ptr<const TriangleMesh> mesh;  ///< kept alive: its address is the key in models_
        gl::Vertices vertices{{3, 3}}, edges{{3, 3, 1}};
        float size = 0;           ///< diagonal of its bounds [m]
        bool has_places = false;  ///< the vertices have texture coordinates
        void fill(const FrameSolid& solid);
    };
    struct Placed {
        FrameSolid solid;
        const Model* model;
        int number;  ///< index of the solid in the frame
    };
    enum class Shape { none, surface, particles };
    /// Fills in the solids and the bounds.
    void fill(const Frame& frame, Shape shape, const Bounds& fluid);
    const Model& model(const FrameSolid& solid);

    gl::Vertices fluid_{{3, 3, 1, 4, 3}}, particles_{{3, 3}};
    gl::Texture plates_;  // two texels per plate: middle and radius; velocity and random number
    float spacing_ = 0;   ///< m
    Shape shape_ = Shape::surface;
    float moment_ = 0;  ///< s
    std::map<const TriangleMesh*, Model> models_;
    void draw(const std::vector<Placed>& placed, gl::Program& program, const std::function<void(const FrameSolid&)>& prepare,
              const std::function<bool(const FrameSolid&)>& wanted) const;
    std::vector<Placed> solids_, containers_, glass_;  ///< opaque solids, containers, solids that refract
    Bounds fluid_bounds_, bounds_;
};

}  // namespace whorl
