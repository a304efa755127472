// What a node of a random graph does: reads, publishes while it holds what it has read, and looks
// whether that has changed.
#pragma once

#include <cstdint>

#include "stator/executor.hpp"

namespace stator::apps {

class Box {
  public:
    template <class Ports>
    void step(Ports& ports, uint32_t count) {
        Held first(ports.i0, draw());
        Held second(ports.i1, draw());
        Held third(ports.i2, draw());
        publish(ports.o0, count);
        first.check();
        publish(ports.o1, count);
        second.check();
        publish(ports.o2, count);
        first.check();
        second.check();
        third.check();
        drain(ports.i0);
        drain(ports.i1);
        drain(ports.i2);
        third.check();
    }

    uint32_t draw() {
        random_ = random_ * 1664525U + 1013904223U;
        return random_ >> 16;
    }

  private:
    // What an input has at the begin of a step; a queue only sometimes.
    template <class Input>
    class Held {
      public:
        Held(Input& input, uint32_t drawn) : input_(input) {
            if (!input && drawn % 2 == 0) input.next();
            if (!input) return;
            sample_ = &*input;
            value_ = sample_->value;
            check();
        }
        void check() const {
            preemption_point();
            if (sample_ == nullptr || !input_ || sample_ != &*input_) return;  // a queue moved on
            require(sample_->value == value_ && sample_->same == value_,
                    "a sample changed while it was held");
        }

      private:
        Input& input_;
        decltype(&*std::declval<Input&>()) sample_ = nullptr;
        uint32_t value_ = 0;
    };

    template <class Output>
    void publish(Output& output, uint32_t count) {
        for (uint32_t i = 0; i < count; ++i) {
            output.publish([&] {
                decltype(message_of(output)) block{};
                block.value = ++published_;
                preemption_point();
                block.same = block.value;
                return block;
            });
        }
    }
    template <template <class> class Output, class Message>
    static Message message_of(const Output<Message>&);

    template <class Input>
    static void drain(Input& input) {
        while (input.next()) {
            const uint32_t value = input->value;
            preemption_point();
            require(input->value == value && input->same == value, "a queued sample changed");
        }
    }

    uint32_t random_ = 1;
    uint32_t published_ = 0;
};

}  // namespace stator::apps
