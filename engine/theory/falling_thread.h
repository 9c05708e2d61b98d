#pragma once
/// A steady thread that its own weight draws out while it falls. Across a slender thread the velocity is even, so that with u(y) the speed
/// y below the nozzle, a its radius and nu the kinematic viscosity (Trouton 1906)
///
///     u a^2 = U a0^2                                 the same volume passes every section
///     3 nu (a^2 u')' + g a^2 = u u' a^2              tension against weight and inertia
///     u(0) = U,  u'(H) = 0                           no tension where the thread is taken away
#include <vector>

namespace whorl {

struct FallingThreadParameters {
    double speed = 0;      ///< m/s, U
    double fall = 0;       ///< m, H
    double gravity = 0;    ///< m/s^2
    double viscosity = 0;  ///< m^2/s, kinematic; above 0
};

class FallingThread {
public:
    /// Integrates upward, where it is stable, from the end speed that gives U at the nozzle.
    explicit FallingThread(const FallingThreadParameters& parameters);
    double speed(double below) const;  ///< m/s, at the distance `below` from the nozzle [m]
    double end_speed() const { return speed_.front(); }
    /// m/s, the speed with which a slice holds its volume: from `below` to `below` + `height` [m], the mean of 1/u, inverted.
    double mean_speed(double below, double height) const;

private:
    double integrate(double end);
    FallingThreadParameters p_;
    std::vector<double> speed_;  ///< at even distances, from the end up
};

/// The end speed without integrating, for estimates. Without inertia sqrt(u) (pi/2 - asin sqrt(U/u)) = H sqrt(g/(6 nu)) at the end;
/// inertia is put in by adding the inverse gain in speed to that of the free fall. Right in both limits, 15 % slow between them (nu = 0.05
/// m^2/s, drawn tenfold). A viscosity of 0 is a free fall.
double fast_end_speed(const FallingThreadParameters& parameters);

}  // namespace whorl
