#include "engine/io/bodies.h"

#include "engine/io/files.h"

namespace whorl {

std::string bodies_header() {
    return "frame,time,solid,x,y,z,turn_w,turn_x,turn_y,turn_z,velocity_x,velocity_y,velocity_z,angular_velocity_x,angular_velocity_y,"
           "angular_velocity_z,"
           "momentum_x,momentum_y,momentum_z,angular_momentum_x,angular_momentum_y,angular_momentum_z,kinetic_energy,potential_energy";
}

std::string bodies_rows(int frame, double time, const World& world, const Vec3d& gravity) {
    std::string rows;
    for (std::size_t k = 0; k < world.solids.all.size(); ++k) {
        if (!world.solids.all[k].body) continue;
        const RigidBody& b = *world.solids.all[k].body;
        const Vec3d w = b.angular_velocity(), p = b.mass * b.velocity, L = b.centre.cross(p) + b.spin_momentum;  // about the origin
        rows += std::to_string(frame);
        for (double value : {time,
                             static_cast<double>(k),
                             b.centre.x(),
                             b.centre.y(),
                             b.centre.z(),
                             b.turn.w(),
                             b.turn.x(),
                             b.turn.y(),
                             b.turn.z(),
                             b.velocity.x(),
                             b.velocity.y(),
                             b.velocity.z(),
                             w.x(),
                             w.y(),
                             w.z(),
                             p.x(),
                             p.y(),
                             p.z(),
                             L.x(),
                             L.y(),
                             L.z(),
                             b.kinetic_energy(),
                             -b.mass * gravity.dot(b.centre)})
            rows += "," + number(value);
        rows += "\n";
    }
    return rows;
}

}  // namespace whorl
