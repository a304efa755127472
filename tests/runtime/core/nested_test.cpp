// Topics between jobs that nest on one stack.
#include "topic_rig.hpp"

namespace stator {
namespace {

using testing::publish;
using testing::Reading;
using testing::TopicOf;

class Nested : public testing::TopicTest {};

TEST_F(Nested, several_publishers_are_numbered_in_one_order) {
    TopicOf<Reading, 4, 7, 2> topic;  // levels 1 and 2 publish, level 3 reads
    std::vector<uint32_t> values;
    uint32_t cursor = 0;
    const Pend subscribers[] = {testing::kHigh};
    topic.topic.subscribers = subscribers;
    topic.topic.subscriber_count = 1;
    testing::jobs[0] = [&] {
        Input<Reading> input;
        input.take_trigger(topic.topic, cursor);
        EXPECT_EQ(input.lost(), 0U);
        values.push_back(input->value);
    };
    testing::jobs[1] = [&] { publish(topic.topic, Reading{0, 2, 0}, 1); };
    testing::jobs[2] = [&] {
        Output<Reading> output;
        output.connect(topic.topic, 1, true);
        output.publish([] {
            set_pending(testing::kMiddle);  // publishes while this sample is built
            preempt();
            return Reading{0, 1, 0};
        });
    };
    set_pending(testing::kLow);
    preempt();
    EXPECT_EQ(values, (std::vector<uint32_t>{2, 1}));
    EXPECT_TRUE(topic.is_idle());
    EXPECT_EQ(topic.state.head.load(), 2U);
}

TEST_F(Nested, publishing_wakes_more_urgent_readers_at_once) {
    TopicOf<Reading, 1, 4> topic;
    const Pend subscribers[] = {{0, testing::kHigh.mask | testing::kLow.mask}};
    topic.topic.subscribers = subscribers;
    topic.topic.subscriber_count = 1;
    std::string order;
    testing::jobs[0] = [&] { order += "high "; };
    testing::jobs[2] = [&] { order += "low "; };
    testing::jobs[1] = [&] {
        publish(topic.topic, Reading{}, 1);
        order += "middle ";
    };
    set_pending(testing::kMiddle);
    preempt();
    EXPECT_EQ(order, "high middle low ");
}

// --- layout: what the table and the words cost on the target ---

TEST(TopicLayout, state_is_three_words_and_slots_count_from_the_top_bit) {
    static_assert(sizeof(Shared<uint32_t>) == 4 && sizeof(Shared<uint8_t>) == 1);
    static_assert(sizeof(TopicState) == 12);
    static_assert(sizeof(TurnState) == 2 * sizeof(void*));
    static_assert(sizeof(Topic) <= 9 * sizeof(void*) + 8);
    static_assert(slot_mask(0) == 0x80000000U && slot_mask(31) == 1U);
    static_assert(all_slots(1) == 0x80000000U && all_slots(32) == 0xFFFFFFFFU);
    static_assert(std::atomic<uint32_t>::is_always_lock_free);
    for (unsigned slot = 0; slot < kMaxSlots; ++slot) {
        EXPECT_EQ(static_cast<unsigned>(std::countl_zero(slot_mask(slot))), slot);
    }
}

}  // namespace
}  // namespace stator
