// Topics and ports as nodes use them, the same on every executor. The unit tests of PX4's uORB
// (uORBTest_UnitTest.cpp) are the least that is asked of them. There, and here:
//   single              absent_before_the_first_publication, is_new_once
//   SubscriptionMulti   two_topics_of_one_message_are_apart
//   multi               two_topics_of_one_message_are_apart
//   multi_reversed      absent_before_the_first_publication, a_late_reader_gets_the_newest
//   unadvertise         topics exist from boot on; for the end of a mode: tests/runtime/virtual
//   multi2              Nested.several_publishers_are_numbered_in_one_order
//   wrap_around         Queue.numbers_survive_wrap_around, and .._at_depth_1
//   queue               Queue.in_order_and_complete, Queue.overflow_loses_the_oldest_and_counts
//   queue_poll_notify   Nested.publishing_wakes_more_urgent_readers_at_once; tests/runtime/virtual
//   latency             no test, as no time is asserted: `./stator bench`
//   orb_set_interval    thinning_keeps_the_mean_rate
#include <gtest/gtest.h>

#include "topic_rig.hpp"

namespace stator {
namespace {

using testing::publish;
using testing::Reading;
using testing::TopicOf;
using testing::TopicTest;

TEST_F(TopicTest, absent_before_the_first_publication) {
    TopicOf<Reading, 1, 2> topic;
    uint32_t cursor = 0;
    Input<Reading> latest;
    latest.take_latest(topic.topic, cursor, 0);
    EXPECT_FALSE(latest);
    EXPECT_FALSE(latest.is_new());
    EXPECT_FALSE(latest.next());
    Input<Reading> trigger;
    trigger.take_trigger(topic.topic, cursor);
    EXPECT_FALSE(trigger);
    EXPECT_FALSE(has_unread(topic.topic, cursor));
    EXPECT_TRUE(topic.is_idle());
}

TEST_F(TopicTest, a_sample_is_read_where_it_was_built) {
    TopicOf<Reading, 1, 2> topic;
    Output<Reading> output;
    output.connect(topic.topic, 7, true);
    output.publish([] { return Reading{.timestamp = 0, .value = 42, ._padding0 = 0}; });
    uint32_t cursor = 0;
    Input<Reading> input;
    input.take_latest(topic.topic, cursor, 8);
    EXPECT_GE(&*input, topic.samples.data());
    EXPECT_LT(&*input, topic.samples.data() + topic.samples.size());
    EXPECT_EQ(input->value, 42U);
}

TEST_F(TopicTest, publishing_stamps_the_activations_time) {
    TopicOf<Reading, 1, 2> topic;
    publish(topic.topic, Reading{.timestamp = 999, .value = 1, ._padding0 = 0}, 1234);
    uint32_t cursor = 0;
    Input<Reading> input;
    input.take_latest(topic.topic, cursor, 1234);
    EXPECT_EQ(input->timestamp, 1234U);
}

TEST_F(TopicTest, an_unconnected_output_publishes_nothing) {
    Output<Reading> output;
    bool was_made = false;
    output.publish([&] {
        was_made = true;
        return Reading{};
    });
    EXPECT_FALSE(output.is_connected());
    EXPECT_FALSE(was_made);
}

TEST_F(TopicTest, a_publication_beyond_the_burst_is_refused_and_counted) {
    TopicOf<Reading, 1, 2> topic;
    Output<Reading> output;
    output.connect(topic.topic, 7, true, 2);
    unsigned made = 0;
    for (uint32_t i = 1; i <= 5; ++i) {
        output.publish([&] {
            ++made;
            return Reading{0, i, 0};
        });
    }
    EXPECT_EQ(output.refused(), 3U);
    EXPECT_EQ(made, 2U);
    EXPECT_EQ(topic.state.head.load(), 2U);
    uint32_t cursor = 0;
    Input<Reading> input;
    input.take_latest(topic.topic, cursor, 7);
    EXPECT_EQ(input->value, 2U);
}

// It would build in the same slot.
TEST_F(TopicTest, a_publication_inside_another_one_is_refused) {
    TopicOf<Reading, 1, 2> topic;
    Output<Reading> output;
    output.connect(topic.topic, 7, true, 3);
    output.publish([&] {
        output.publish([] { return Reading{0, 9, 0}; });
        return Reading{0, 1, 0};
    });
    EXPECT_EQ(output.refused(), 1U);
    EXPECT_EQ(topic.state.head.load(), 1U);
    output.publish([] { return Reading{0, 2, 0}; });
    output.publish([] { return Reading{0, 3, 0}; });
    EXPECT_EQ(output.refused(), 1U) << "the outer one counts once";
    EXPECT_EQ(topic.state.head.load(), 3U);
    EXPECT_TRUE(topic.is_idle());
}

TEST_F(TopicTest, is_new_once) {
    TopicOf<Reading, 1, 2> topic;
    publish(topic.topic, Reading{0, 5, 0}, 10);
    uint32_t cursor = 0;
    for (const bool expected : {true, false}) {
        Input<Reading> input;
        input.take_latest(topic.topic, cursor, 10);
        EXPECT_EQ(input->value, 5U);
        EXPECT_EQ(input.is_new(), expected);
        EXPECT_EQ(input.next(), expected);
        EXPECT_FALSE(input.next());
        EXPECT_EQ(input->value, 5U) << "next() keeps a latest sample";
    }
}

TEST_F(TopicTest, a_late_reader_gets_the_newest) {
    TopicOf<Reading, 4, 6> topic;
    for (uint32_t i = 1; i <= 9; ++i) publish(topic.topic, Reading{0, i, 0}, i);
    uint32_t cursor = 0;
    Input<Reading> input;
    input.take_latest(topic.topic, cursor, 9);
    EXPECT_EQ(input->value, 9U);
    EXPECT_EQ(input.number(), 9U);
    EXPECT_EQ(input.lost(), 8U);
}

TEST_F(TopicTest, two_topics_of_one_message_are_apart) {
    TopicOf<Reading, 1, 2> left;
    TopicOf<Reading, 1, 2> right;
    publish(left.topic, Reading{0, 103, 0}, 1);
    publish(right.topic, Reading{0, 203, 0}, 2);
    uint32_t cursors[2] = {};
    Input<Reading> inputs[2];
    inputs[0].take_latest(left.topic, cursors[0], 2);
    inputs[1].take_latest(right.topic, cursors[1], 2);
    EXPECT_EQ(inputs[0]->value, 103U);
    EXPECT_EQ(inputs[1]->value, 203U);
}

TEST_F(TopicTest, a_latest_input_counts_what_passed_unread) {
    TopicOf<Reading, 1, 2> topic;
    uint32_t cursor = 0;
    for (const uint32_t published : {1U, 3U, 0U, 1U}) {
        for (uint32_t i = 0; i < published; ++i) publish(topic.topic, Reading{}, 0);
        Input<Reading> input;
        input.take_latest(topic.topic, cursor, 0);
        EXPECT_EQ(input.lost(), published > 1 ? published - 1 : 0U);
        EXPECT_EQ(input.is_new(), published != 0);
    }
}

TEST_F(TopicTest, an_old_sample_reads_as_absent) {
    TopicOf<Reading, 1, 2> topic;
    publish(topic.topic, Reading{0, 1, 0}, 1000);
    for (const auto& [now_us, is_there] : {std::pair{1050U, true}, std::pair{1051U, false}}) {
        uint32_t cursor = 0;
        Input<Reading> input;
        input.take_latest(topic.topic, cursor, now_us, 50);
        EXPECT_EQ(static_cast<bool>(input), is_there) << now_us;
        EXPECT_EQ(input.next(), is_there) << now_us;
        EXPECT_TRUE(topic.is_idle() || is_there) << "an absent sample holds no slot";
    }
}

TEST_F(TopicTest, a_sample_stamped_later_than_now_is_young) {
    TopicOf<Reading, 1, 2> topic;
    publish(topic.topic, Reading{}, 1000);
    uint32_t cursor = 0;
    Input<Reading> input;
    input.take_latest(topic.topic, cursor, 990, 50);
    EXPECT_TRUE(input);
}

TEST_F(TopicTest, an_old_trigger_sample_reads_as_absent_and_is_consumed) {
    TopicOf<Reading, 2, 4> topic;
    publish(topic.topic, Reading{}, 1000);
    uint32_t cursor = 0;
    {
        Input<Reading> input;
        input.take_trigger(topic.topic, cursor);
        input.limit_age(2000, 500);
        EXPECT_FALSE(input);
    }
    EXPECT_FALSE(has_unread(topic.topic, cursor));
    EXPECT_TRUE(topic.is_idle());
}

TEST_F(TopicTest, a_queue_skips_samples_that_are_too_old) {
    TopicOf<Reading, 4, 6> topic;
    for (uint32_t i = 1; i <= 4; ++i) publish(topic.topic, Reading{0, i, 0}, i * 100);
    uint32_t cursor = 0;
    Input<Reading> input;
    input.open_queue(topic.topic, cursor, 400, 150);
    ASSERT_TRUE(input.next());
    EXPECT_EQ(input->value, 3U);
    ASSERT_TRUE(input.next());
    EXPECT_EQ(input->value, 4U);
    EXPECT_FALSE(input.next());
    EXPECT_FALSE(input);
    EXPECT_TRUE(topic.is_idle());
}

TEST_F(TopicTest, numbers_survive_wrap_around_at_depth_1) {
    TopicOf<Reading, 1, 3> topic(0xFFFFFFFEU);
    uint32_t trigger_cursor = 0xFFFFFFFEU;
    uint32_t latest_cursor = 0xFFFFFFFEU;
    for (uint32_t i = 0; i < 4; ++i) {
        publish(topic.topic, Reading{0, i, 0}, i);
        Input<Reading> trigger;
        trigger.take_trigger(topic.topic, trigger_cursor);
        ASSERT_TRUE(trigger);
        EXPECT_EQ(trigger.number(), 0xFFFFFFFFU + i);
        EXPECT_EQ(trigger.lost(), 0U);
        if (i % 2 == 0) continue;
        Input<Reading> latest;
        latest.take_latest(topic.topic, latest_cursor, i);
        EXPECT_TRUE(latest.is_new());
        EXPECT_EQ(latest.lost(), 1U);
    }
}

// A held sample stays as it is while its slot's neighbours are written again and again.
TEST_F(TopicTest, a_held_sample_does_not_change) {
    TopicOf<Reading, 2, 4> topic;
    publish(topic.topic, Reading{0, 77, 0}, 1);
    uint32_t cursor = 0;
    {
        Input<Reading> input;
        input.take_latest(topic.topic, cursor, 1);
        for (uint32_t i = 0; i < 20; ++i) publish(topic.topic, Reading{0, i, 0}, i);
        EXPECT_EQ(input->value, 77U);
    }
    EXPECT_TRUE(topic.is_idle());
}

TEST_F(TopicTest, one_slot_too_few_is_found_at_the_loan) {
    TopicOf<Reading, 1, 1> topic;
    publish(topic.topic, Reading{}, 0);
    uint32_t cursor = 0;
    Input<Reading> input;
    input.take_latest(topic.topic, cursor, 0);
    EXPECT_DEATH(publish(topic.topic, Reading{}, 0), "topic: no free slot");
}

// --- thinning ---

unsigned times_woken(uint32_t sample_period_us, uint32_t interval_us, uint64_t duration_us) {
    TopicOf<Reading, 1, 2> topic;
    ThinnedState state;
    const Thinned thinned[] = {{&state, interval_us, testing::kHigh}};
    const Pend thinned_words[] = {{0, 0}};
    topic.topic.thinned = thinned;
    topic.topic.thinned_count = 1;
    topic.topic.subscribers = thinned_words;
    topic.topic.subscriber_count = 1;
    for (uint64_t now_us = 0; now_us < duration_us; now_us += sample_period_us) {
        publish(topic.topic, Reading{}, now_us);
    }
    return state.fires.load();
}

TEST_F(TopicTest, thinning_keeps_the_mean_rate) {
    // A sample every 3 ms, thinned to 10 ms: comparing with the last one would give 12 ms.
    EXPECT_EQ(times_woken(3000, 10000, 3'000'000), 300U);
    EXPECT_EQ(times_woken(1000, 4000, 1'000'000), 250U);
    // Rarer samples than the interval all pass.
    EXPECT_EQ(times_woken(20000, 10000, 1'000'000), 50U);
}

TEST_F(TopicTest, a_pause_of_a_thinned_topic_is_not_made_up_for) {
    TopicOf<Reading, 1, 2> topic;
    ThinnedState state;
    const Thinned thinned[] = {{&state, 1000, testing::kHigh}};
    const Pend thinned_words[] = {{0, 0}};
    topic.topic.thinned = thinned;
    topic.topic.thinned_count = 1;
    topic.topic.subscribers = thinned_words;
    topic.topic.subscriber_count = 1;
    for (const uint64_t now_us : {0U, 100000U, 100100U, 101000U}) {
        publish(topic.topic, Reading{}, now_us);
    }
    EXPECT_EQ(state.fires.load(), 3U);  // at 0, 100 and 101 ms
}

}  // namespace
}  // namespace stator
