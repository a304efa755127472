// What the readers of a recorded sample see of it.
#include <bit>

#include "topic_rig.hpp"

namespace stator {
namespace {

struct Measured {
    uint64_t timestamp;
    float value;
    uint32_t _padding0;
};

class RecordedTopic : public testing::TopicTest {};

// A replay gives each reader the recorded sample. So one that runs inside the publication must not
// see other bits of a NaN than those that run after it.
TEST_F(RecordedTopic, a_more_urgent_reader_gets_the_canonical_nan) {
    testing::TopicOf<Measured, 1, 3> topic;
    const Pend subscribers[] = {testing::kHigh};
    topic.topic.subscribers = subscribers;
    topic.topic.subscriber_count = 1;
    uint32_t seen = 0;
    testing::jobs[0] = [&] {
        uint32_t number = 0;
        Input<Measured> input;
        input.take_latest(topic.topic, number, 1);
        seen = std::bit_cast<uint32_t>(input->value);
    };
    testing::jobs[1] = [&] {
        std::array<uint8_t, 64> bytes{};
        RecordStream stream(bytes.data(), bytes.size());
        constexpr FloatRun kFloats[] = {{offsetof(Measured, value), 1, sizeof(float)}};
        const RecordedOutput recorded{1, RecordedOutput::How::kHash, kFloats, 1};
        uint32_t number = 0;
        Output<Measured> output;
        output.tap().connect(stream, recorded, number);
        output.connect(topic.topic, 1, true);
        output.publish([] { return Measured{0, std::bit_cast<float>(0xFFC01234U), 0}; });
    };
    set_pending(testing::kMiddle);
    preempt();
    EXPECT_EQ(seen, 0x7FC00000U);
}

}  // namespace
}  // namespace stator
