// Changes parameters of all nodes, its own among them, several times in one activation.
#pragma once

#include <bit>

#include "stator/executor.hpp"
#include "tuner_ports.hpp"

namespace stator::apps::tuner {

class Tuner {
  public:
    void step(TunerPorts& ports) {
        const float before = ports.params->first;
        for (unsigned i = 0; i < 6; ++i) {
            const auto rows = ports.parameters.rows();
            random_ = random_ * 1664525U + 1013904223U;
            // Its own, which stand last, every other time.
            const ParameterRow& row =
                i % 2 == 0 ? rows.back() : rows[(random_ >> 16) % rows.size()];
            const uint32_t drawn = random_ >> 28;
            const bool is_float = row.type == ParameterType::kFloat;
            const auto value = is_float
                                   ? std::bit_cast<ParameterBits>(static_cast<float>(drawn) / 16)
                                   : ParameterBits{drawn % 10};
            ports.parameters.publish(row, value);
            preemption_point();
            require(ports.parameters.value(row) == value, "what was published is not the newest");
            require(ports.params->first == before, "parameters changed while they were held");
        }
    }

  private:
    uint32_t random_ = 7;
};

}  // namespace stator::apps::tuner
