#include "engine/geometry/repeats.h"

namespace whorl {

Repeats::Repeats(const Shape& shape, const Domain& domain, const Mat3& rotation, const Vec3& translation) {
    if (!domain.any_periodic() || !shape.bounded()) return;
    Vec3 low, high;
    shape.bounds(low, high);
    centre_ = rotation * ((low + high) / 2) + translation;
    half_ = rotation.cwiseAbs() * ((high - low) / 2);
    period_ = domain.period();
    any_ = true;
    for (int a = 0; a < 3; ++a) {
        int own = 0;
        const bool along = rotation.row(a).cwiseAbs().maxCoeff(&own) > 1 - Real(1e-6);
        endless_[a] = period_[a] > 0 && along && shape.prismatic(own) && 2 * half_[a] >= period_[a] * (1 - Real(1e-5));
        if (endless_[a]) period_[a] = 0;
        if (period_[a] > 0) axes_ |= 1U << a;
    }
}

std::vector<Vec3> Repeats::shifts_into(const Domain& domain) const {
    std::vector<Vec3> shifts{any_ ? Vec3(domain.wrapped(centre_) - centre_) : Vec3(Vec3::Zero())};
    for (int a = 0; any_ && a < 3; ++a) {
        if (!(period_[a] > 0) || 2 * half_[a] >= period_[a]) continue;
        const Real middle = centre_[a] + shifts[0][a];
        const Vec3 along = Vec3::Unit(a) * period_[a];
        for (std::size_t k = shifts.size(); k-- > 0;) {
            if (middle - half_[a] < domain.min[a]) shifts.push_back(shifts[k] + along);
            if (middle + half_[a] > domain.max[a]) shifts.push_back(shifts[k] - along);
        }
    }
    return shifts;
}

std::shared_ptr<const Shape> make_shape(const ShapeKeys& keys, const Domain& domain) {
    std::shared_ptr<const Shape> shape = make_shape(keys);
    if (!domain.any_periodic() || !shape->bounded()) return shape;
    return std::make_shared<Repeated>(std::move(shape), domain);
}

}  // namespace whorl
