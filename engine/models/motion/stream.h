#pragma once
/// Streams: boxes in which the fluid is brought to a velocity of its own.
#include <cmath>
#include <vector>

#include "engine/core/parallel.h"
#include "engine/math/expression.h"
#include "engine/particles/field.h"
#include "engine/particles/step_context.h"

namespace whorl {

struct Stream {
    Vec3 min, max;              ///< m
    VectorExpression velocity;  ///< m/s, of t
    double time = 0;            ///< s, in which the difference to it falls to 1/e
};

/// a += (v - u) (1 - exp(-dt/time))/dt in each box, v its velocity: exact for steps of any length where nothing else acts.
struct FollowStreams {
    std::vector<Stream> streams;
    void operator()(const StepContext& step, Read<field::position> x, Read<field::velocity> u, Update<field::acceleration> a) const {
        for (const Stream& stream : streams) {
            const Vec3 v = stream.velocity(step.time).cast<Real>();
            const double dt = static_cast<double>(step.dt);
            const auto rate = static_cast<Real>(-std::expm1(-dt / stream.time) / dt);
            parallel_for(a.size(), [&](Index i) {
                if (Vec3 at = x[i]; step.domain.image_in_box(at, stream.min, stream.max)) a[i] += rate * (v - u[i]);
            });
        }
    }
};

}  // namespace whorl
