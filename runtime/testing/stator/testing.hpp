// For unit tests of nodes: a topic without a graph, to see what an output published.
#pragma once

#include <array>
#include <cstdint>

#include "stator/port.hpp"

namespace stator::testing {

// A topic of two slots that no graph has.
template <class Message>
class LoneTopic {
  public:
    LoneTopic() = default;
    LoneTopic(const LoneTopic&) = delete;
    LoneTopic& operator=(const LoneTopic&) = delete;

    Topic& topic() { return topic_; }
    uint32_t count() const { return state_.head.load(); }  // of publications
    const Message& newest() const {
        require(count() != 0, "probe: nothing was published");
        return samples_[static_cast<unsigned>(std::countl_zero(state_.history.load()))];
    }

  private:
    TopicState state_{Shared<uint32_t>(all_slots(2)), {}, {}};
    std::array<Message, 2> samples_{};
    std::array<Shared<uint32_t>, 2> number_{};
    Topic topic_{.state = &state_,
                 .samples = samples_.data(),
                 .number = number_.data(),
                 .ring = nullptr,
                 .subscribers = nullptr,
                 .thinned = nullptr,
                 .in_section = nullptr,
                 .sample_bytes = sizeof(Message),
                 .subscriber_count = 0,
                 .thinned_count = 0,
                 .slots = 2,
                 .depth = 1,
                 .ceiling = 0};
};

// Connects to an output and keeps its newest sample.
template <class Message>
class Probe {
  public:
    // `burst`: publications that it takes; a graph takes as many as the node's interface says.
    Probe(Output<Message>& output, uint64_t now_us, uint16_t burst = UINT16_MAX) {
        output.connect(topic_.topic(), now_us, true, burst);
    }

    uint32_t count() const { return topic_.count(); }
    const Message& newest() const { return topic_.newest(); }

  private:
    LoneTopic<Message> topic_;
};

}  // namespace stator::testing
