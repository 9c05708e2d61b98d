#pragma once
/// Pixels of a sample, marked in the stencil by what they show.
#include "render/gl/objects.h"

namespace whorl {

/// Stencil values of pixels that show a solid, and of pixels that show the fluid.
constexpr GLint solid_seen = 1, fluid_seen = 2;

/// Prepares for drawing solids or the fluid down to the height `lowest` [m]; drawn pixels get the stencil value `seen`.
inline void begin_geometry(gl::Program& program, GLint seen, float lowest) {
    program.set("cuts", 1);
    program.set("lowest", lowest);
    glEnable(GL_CLIP_DISTANCE0);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, seen, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
}

inline void end_geometry() {
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_STENCIL_TEST);
}

/// Limits drawing to pixels whose stencil value passes the comparison with `seen`; other pixels cost the software driver nothing.
inline void shade_where(GLenum comparison, GLint seen) {
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(comparison, seen, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
}

}  // namespace whorl
