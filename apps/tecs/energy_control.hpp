// Total energy control: throttle sets the rate of energy, pitch how it is shared between height
// and speed. Lambregts: Vertical Flight Path and Speed Control Autopilot Design Using Total Energy
// Principles, AIAA 83-2239, 1983.
#pragma once

#include "tecs_ports.hpp"

namespace stator::apps::tecs {

// SI units; airspeeds are true ones.
struct Motion {
    float height;
    float height_rate;
    float airspeed;  // not a number: not known
    float airspeed_rate;
    float load_factor;  // of the wing, from the bank
    float tas_over_eas;
    float pitch;
};

// Not a number: left free. Without height and height rate, pitch holds the airspeed alone.
struct Wanted {
    float height;
    float height_rate;
    float airspeed;
    float pitch;     // directly, instead of the heights
    float throttle;  // directly
};

// Rates per unit of mass, with w_p and w_k from the speed weight (0 height alone, 2 speed alone):
//
//     total    g h' + V V'              throttle, from trim, least and most throttle
//     balance  w_p g h' - w_k V V'      pitch = (wanted + damping * error) / (V g) + integral
//
// Below the least airspeed, times the root of the load factor, the weight moves to speed and the
// throttle to its most. The height reference moves at the target rates. Where control begins, the
// reference is the height and the integral the angle of attack.
class EnergyControl {
  public:
    void reset() { is_running_ = false; }
    void update(const Motion& motion, const Wanted& wanted, const TecsParams& params, float dt);

    float pitch() const { return status_.pitch_sp_rad; }
    float throttle() const { return status_.throttle_sp; }
    const TecsStatus& status() const { return status_; }

  private:
    void start(const Motion& motion, const TecsParams& params);
    float height_rate_for(const Motion& motion, const Wanted& wanted, const TecsParams& params,
                          float dt);
    void set_throttle(float wanted, float rate, float underspeed, const TecsParams& params,
                      float dt);
    void set_pitch(float wanted, float rate, float speed, const TecsParams& params, float dt);

    bool is_running_ = false;
    float reference_ = 0.0F;
    float reference_rate_ = 0.0F;
    float energy_rate_ = 0.0F;  // low-passed
    TecsStatus status_{};
};

}  // namespace stator::apps::tecs
