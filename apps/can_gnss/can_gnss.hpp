// A receiver of satellite navigation on a CAN bus: DroneCAN's gnss.Fix2 and gnss.Auxiliary become
// SensorGps.
#pragma once

#include "can_gnss_ports.hpp"
#include "dronecan/equipment/gnss/auxiliary.hpp"
#include "dronecan/equipment/gnss/fix2.hpp"
#include "stator/dronecan/receiver.hpp"

namespace stator::apps::can_gnss {

// The first node that is heard is the receiver, until it has been silent for some seconds. A fix
// with an impossible value is dropped whole, and counted. What the receiver does not know is NaN;
// an error that is missing in the fix comes from the geometry, if that has been heard.
class CanGnss {
  public:
    using Fix = dronecan::equipment::gnss::Fix2;
    using Geometry = dronecan::equipment::gnss::Auxiliary;

    CanGnss();
    void step(CanGnssPorts& ports);
    const dronecan::ReceiverCounters& counters() const { return receiver_.counters(); }

  private:
    void configure(const CanGnssParams& params);
    void receive(CanGnssPorts& ports);
    bool is_ours(uint64_t now_us);
    void take_fix(CanGnssPorts& ports);
    void take_geometry(uint64_t now_us);
    SensorGps sample(const Fix& fix, const CanGnssParams& params) const;

    dronecan::Receiver<4, Fix::kType.most_bytes> receiver_;
    uint64_t heard_us_ = 0;
    uint64_t geometry_us_ = 0;
    Geometry geometry_{};
    uint8_t node_ = 0;
};

}  // namespace stator::apps::can_gnss
