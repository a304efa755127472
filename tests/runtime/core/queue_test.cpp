// Queue readers at every depth: order, completeness, losses, numbers across wrap-around.
#include "topic_rig.hpp"

namespace stator {
namespace {

using testing::publish;
using testing::Reading;
using testing::TopicOf;
using testing::TopicTest;

template <class Depth>
class Queue : public TopicTest {
  protected:
    static constexpr unsigned kQueueDepth = Depth::value;
    using Sized = TopicOf<Reading, kQueueDepth, kQueueDepth + 2>;
};
template <unsigned depth>
using Depth = std::integral_constant<unsigned, depth>;
using Depths = ::testing::Types<Depth<2>, Depth<4>, Depth<8>, Depth<16>>;
TYPED_TEST_SUITE(Queue, Depths);

TYPED_TEST(Queue, in_order_and_complete) {
    constexpr unsigned kDepth = TestFixture::kQueueDepth;
    typename TestFixture::Sized topic;
    uint32_t cursor = 0;
    uint32_t expected = 1;
    uint32_t published = 0;
    for (unsigned round = 0; round < 5; ++round) {
        for (unsigned i = 0; i < kDepth; ++i) publish(topic.topic, Reading{0, ++published, 0}, 0);
        Input<Reading> input;
        input.open_queue(topic.topic, cursor, 0);
        EXPECT_FALSE(input) << "absent until next()";
        while (input.next()) {
            EXPECT_EQ(input->value, expected);
            EXPECT_EQ(input.number(), expected);
            EXPECT_TRUE(input.is_new());
            ++expected;
        }
        EXPECT_EQ(input.lost(), 0U);
    }
    EXPECT_EQ(expected, published + 1);
    EXPECT_TRUE(topic.is_idle());
}

TYPED_TEST(Queue, overflow_loses_the_oldest_and_counts) {
    constexpr unsigned kDepth = TestFixture::kQueueDepth;
    typename TestFixture::Sized topic;
    const uint32_t published = 3 * kDepth + 1;
    for (uint32_t i = 1; i <= published; ++i) publish(topic.topic, Reading{0, i, 0}, 0);
    uint32_t cursor = 0;
    Input<Reading> input;
    input.open_queue(topic.topic, cursor, 0);
    for (uint32_t i = published - kDepth + 1; i <= published; ++i) {
        ASSERT_TRUE(input.next());
        EXPECT_EQ(input->value, i);
    }
    EXPECT_FALSE(input.next());
    EXPECT_EQ(input.lost(), published - kDepth);
}

TYPED_TEST(Queue, a_trigger_consumes_one_sample_for_each_activation) {
    typename TestFixture::Sized topic;
    publish(topic.topic, Reading{0, 1, 0}, 0);
    publish(topic.topic, Reading{0, 2, 0}, 0);
    uint32_t cursor = 0;
    for (const uint32_t expected : {1U, 2U}) {
        EXPECT_TRUE(has_unread(topic.topic, cursor));
        Input<Reading> input;
        input.take_trigger(topic.topic, cursor);
        EXPECT_EQ(input->value, expected);
        EXPECT_TRUE(input.next());
        EXPECT_FALSE(input.next());
    }
    EXPECT_FALSE(has_unread(topic.topic, cursor));
}

TYPED_TEST(Queue, numbers_survive_wrap_around) {
    constexpr unsigned kDepth = TestFixture::kQueueDepth;
    const uint32_t first = 0U - kDepth / 2 - 1;
    typename TestFixture::Sized topic(first);
    uint32_t cursor = first;
    for (uint32_t i = 1; i <= kDepth + 1; ++i) publish(topic.topic, Reading{0, i, 0}, 0);
    Input<Reading> input;
    input.open_queue(topic.topic, cursor, 0);
    for (uint32_t i = 2; i <= kDepth + 1; ++i) {
        ASSERT_TRUE(input.next());
        EXPECT_EQ(input->value, i);
        EXPECT_EQ(input.number(), first + i);
    }
    EXPECT_FALSE(input.next());
    EXPECT_EQ(input.lost(), 1U);
}

TYPED_TEST(Queue, next_goes_on_where_a_publication_in_between_left_it) {
    typename TestFixture::Sized topic;
    publish(topic.topic, Reading{0, 1, 0}, 0);
    uint32_t cursor = 0;
    Input<Reading> input;
    input.open_queue(topic.topic, cursor, 0);
    ASSERT_TRUE(input.next());
    EXPECT_FALSE(input.next());
    publish(topic.topic, Reading{0, 2, 0}, 0);
    ASSERT_TRUE(input.next());
    EXPECT_EQ(input->value, 2U);
}

}  // namespace
}  // namespace stator
