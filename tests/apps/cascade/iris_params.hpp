// The parameters that the cascade is tested with: the interfaces' defaults, which are for the Iris.
#pragma once

#include "allocation_ports.hpp"
#include "attitude_control_ports.hpp"
#include "position_control_ports.hpp"
#include "rate_control_ports.hpp"
#include "sequence_ports.hpp"

namespace stator::testing {

inline constexpr RateControlParams kRateControlParams{
    .timestamp = 0,
    .roll_p = 0.22F,
    .roll_i = 0.3F,
    .roll_d = 0.0035F,
    .pitch_p = 0.35F,
    .pitch_i = 0.5F,
    .pitch_d = 0.0055F,
    .yaw_p = 0.4F,
    .yaw_i = 0.2F,
    .yaw_d = 0.0F,
    .integral_limit = 0.3F,
    .derivative_cutoff = 50.0F,
    .integrate_from = 0.2F,
};

inline constexpr AttitudeControlParams kAttitudeControlParams{
    .timestamp = 0,
    .tilt_p = 7.0F,
    .yaw_p = 2.0F,
    .roll_rate_limit = 3.8F,
    .pitch_rate_limit = 3.8F,
    .yaw_rate_limit = 1.5F,
};

// The other eight rotors are absent.
inline constexpr AllocationParams kAllocationParams{
    .timestamp = 0,
    .idle = 0.02F,
    .airmode = false,
    .rotor_count = 4,
    .rotor0_x = 0.13F,
    .rotor0_y = 0.22F,
    .rotor0_moment = 0.06F,
    .rotor1_x = -0.13F,
    .rotor1_y = -0.2F,
    .rotor1_moment = 0.06F,
    .rotor2_x = 0.13F,
    .rotor2_y = -0.22F,
    .rotor2_moment = -0.06F,
    .rotor3_x = -0.13F,
    .rotor3_y = 0.2F,
    .rotor3_moment = -0.06F,
};

inline constexpr PositionControlParams kPositionControlParams{
    .timestamp = 0,
    .horizontal_p = 1.0F,
    .horizontal_velocity_p = 2.2F,
    .horizontal_velocity_i = 0.5F,
    .horizontal_velocity_d = 0.1F,
    .vertical_p = 1.0F,
    .vertical_velocity_p = 4.0F,
    .vertical_velocity_i = 2.0F,
    .vertical_velocity_d = 0.0F,
    .derivative_cutoff = 5.0F,
    .integral_limit = 4.0F,
    .horizontal_speed_limit = 4.0F,
    .climb_limit = 2.0F,
    .descent_limit = 1.0F,
    .tilt_limit = 0.6F,
    .hover_thrust = 0.533F,
    .thrust_min = 0.1F,
    .thrust_max = 0.9F,
    .spool_up_time = 1.0F,
    .blind_sink = 0.3F,
};

inline constexpr SequenceParams kSequenceParams{
    .timestamp = 0,
    .start_delay = 2.0F,
    .spool_up_time = 1.5F,
    .north = 0.0F,
    .east = 0.0F,
    .height = 2.0F,
    .heading = 0.0F,
    .hover_time = 30.0F,
    .takeoff_rate = 0.7F,
    .landing_rate = 0.4F,
    .speed = 1.0F,
    .acceleration = 0.5F,
    .yaw_rate = 0.5F,
};

}  // namespace stator::testing
