// A logger that holds inputs of its own, and looks at all that it logs.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "collector_ports.hpp"
#include "stator/executor.hpp"

namespace stator::apps::collector {

class Collector {
  public:
    void step(CollectorPorts& ports) {
        const std::vector<std::byte> before = held(ports);
        for (uint32_t i = 0; i < ports.log->topic_count; ++i) {
            const LogTopic& row = ports.log->topics[i];
            Pin pin;
            // Long where it holds another sample: so that others publish meanwhile.
            const unsigned points = reads(ports, *row.topic) ? 4000 : 20;
            while (take_logged(row, ports.now, pin)) look_at(*row.topic, pin, points);
        }
        const LogChanges* const changes = ports.log->changes;
        for (uint32_t i = 0; changes != nullptr && i < changes->table->topic_count; ++i) {
            const Topic& topic = *changes->table->topics[i].topic;
            Pin pin;
            if (!take_latest(topic, changes->seen[i], pin)) continue;
            changes->seen[i] = number_of(topic, pin);
            // The last ones are those of the node that publishes them.
            look_at(topic, pin, i + 1 == changes->table->topic_count ? 4000 : 20);
        }
        require(held(ports) == before, "an input of the logger changed while it was held");
    }

  private:
    static std::vector<std::byte> held(const CollectorPorts& ports) {
        std::vector<std::byte> bytes;
        const auto add = [&](const auto& input) {
            if (!input) return;
            const auto* const at = reinterpret_cast<const std::byte*>(&*input);
            bytes.insert(bytes.end(), at, at + sizeof *input);
        };
        add(ports.i0);
        add(ports.i1);
        add(ports.i2);
        add(ports.params);
        return bytes;
    }
    static bool reads(const CollectorPorts& ports, const Topic& topic) {
        const auto has = [&](const auto& input) {
            const auto* const begin = static_cast<const std::byte*>(topic.samples);
            const auto* const at = input ? reinterpret_cast<const std::byte*>(&*input) : nullptr;
            return at >= begin && at < begin + size_t{topic.slots} * topic.sample_bytes;
        };
        return has(ports.i0) || has(ports.i1) || has(ports.i2);
    }
    static void look_at(const Topic& topic, const Pin& pin, unsigned points) {
        const std::byte* const at = sample_of(topic, pin);
        const std::vector<std::byte> before(at, at + topic.sample_bytes);
        for (unsigned i = 0; i < points; ++i) preemption_point();
        require(std::memcmp(at, before.data(), before.size()) == 0, "a logged sample changed");
        release(topic, pin);
    }
};

}  // namespace stator::apps::collector
