// The satellite receiver of a simulated board: publishes the fix that the board received.
#pragma once

#include "gnss_ports.hpp"
#include "gnss_sim_sample.hpp"

namespace stator::drivers::gnss::sim {

class GnssSim {
  public:
    // The newest fix. The board writes it, then raises received.
    using Device = GnssSimSample;

    explicit GnssSim(Device& device) : device_(device) {}
    void step(GnssPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::gnss::sim
