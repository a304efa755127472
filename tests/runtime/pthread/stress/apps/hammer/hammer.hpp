// A node that publishes much, and looks closely at what it reads.
#pragma once

#include <array>
#include <cstdint>

#include "hammer_ports.hpp"

namespace stator::apps::hammer {

// Whether all of a block is of one publication, by a source that there is.
bool is_whole(const Block& block);

class Hammer {
  public:
    void step(HammerPorts& ports);

  private:
    // What one input has seen. Values of a source only go up on every topic.
    struct Watch {
        bool has_number = false;
        uint32_t number = 0;
        std::array<uint64_t, 64> values{};
    };

    static void check(Watch& watch, const Input<Block>& input, uint32_t lost);
    void publish(HammerPorts& ports);
    void linger(int32_t loops);

    Watch a_;
    Watch b_;
    Watch c_;
    uint32_t random_ = 1;
};

}  // namespace stator::apps::hammer
