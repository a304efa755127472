// Follows the true flight.
#include "world/flight_watch.hpp"

namespace stator::world {

void FlightWatch::see(const Plant& plant, bool motors_are_stopped) {
    const bool on_ground = plant.is_on_ground();
    const double z = plant.state().position_N.z();
    if (on_ground) {
        left_ground_us_.reset();
        if (take_off_us_ && !touchdown_) touchdown_ = Touchdown{plant.time_us(), sink_speed_};
    } else if (!left_ground_us_) {
        left_ground_us_ = plant.time_us();
    }
    if (left_ground_us_ && start_z_ - z > kAirborneHeight) {
        if (!take_off_us_) take_off_us_ = left_ground_us_;
        touchdown_.reset();  // a hop
    }
    sink_speed_ = plant.state().velocity_N.z();

    if (!motors_are_stopped || !take_off_us_) {
        stopped_us_.reset();
    } else if (!stopped_us_) {
        stopped_us_ = plant.time_us();
    }
}

bool FlightWatch::is_over(std::uint64_t now_us) const {
    return stopped_us_ && now_us - *stopped_us_ >= kStandstill_us;
}

}  // namespace stator::world
