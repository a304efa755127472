// Requests of the link's clients: one at a time, each with one answer, whatever the others do.
#include <gtest/gtest.h>

#include <bit>
#include <optional>
#include <vector>

#include "stator/answers.hpp"
#include "stator/testing.hpp"
#include "terminal_box.hpp"

namespace stator::drivers::terminal::box {
namespace {

using Progress = ParameterBox::Progress;
using Bytes = std::vector<uint8_t>;

constexpr uint8_t kSet = static_cast<uint8_t>(ParameterRequest::Action::kSet);
constexpr uint8_t kFloat = static_cast<uint8_t>(ParameterRequest::Type::kFloat);
constexpr uint8_t kInt = static_cast<uint8_t>(ParameterRequest::Type::kInt32);

struct Terminal : ::testing::Test {
    // One activation of the driver. The request that it published, if any.
    std::optional<ParameterRequest> step(const ParameterValue* value = nullptr) {
        now_us += 10'000;
        TerminalPorts ports{.now = now_us,
                            .value = value == nullptr ? Input<ParameterValue>() : Input(*value)};
        stator::testing::Probe request(ports.request, now_us);
        driver.step(ports);
        if (request.count() == 0) return {};
        return request.newest();
    }
    static ParameterValue answer_to(const ParameterRequest& request, float value) {
        return {.requester = ParameterValue::Requester::kLink,
                .tag = request.tag,
                .result = ParameterValue::Result::kWritten,
                .type = static_cast<ParameterValue::Type>(request.type),
                .float_value = value,
                .int_value = static_cast<int32_t>(value)};
    }
    Progress ask(const ParameterBox::Ask& wanted) { return device.box.ask(wanted, answer); }

    TerminalBox::Device device;
    TerminalBox driver{device};
    ParameterBox::Answer answer{};
    uint64_t now_us = 0;
};

const ParameterBox::Ask kOne{
    .index = 7, .tag = 100, .action = kSet, .type = kFloat, .value = std::bit_cast<uint32_t>(1.5F)};
const ParameterBox::Ask kOther{
    .index = 3, .tag = 200, .action = kSet, .type = kInt, .value = 0xFFFFFFFE};

TEST_F(Terminal, a_request_becomes_a_sample_and_its_answer_comes_back) {
    EXPECT_EQ(ask(kOne), Progress::kPending);
    const auto request = step();
    ASSERT_TRUE(request);
    EXPECT_EQ(request->requester, ParameterRequest::Requester::kLink);
    EXPECT_EQ(request->action, ParameterRequest::Action::kSet);
    EXPECT_EQ(request->index, 7);
    EXPECT_EQ(request->float_value, 1.5F);
    EXPECT_EQ(request->name[0], 0);
    EXPECT_EQ(ask(kOne), Progress::kPending);
    EXPECT_FALSE(step()) << "it is published once";
    const ParameterValue value = answer_to(*request, 1.5F);
    step(&value);
    EXPECT_EQ(ask(kOne), Progress::kConcluded);
    EXPECT_EQ(answer.value, std::bit_cast<uint32_t>(1.5F));
    EXPECT_EQ(answer.result, static_cast<uint8_t>(ParameterValue::Result::kWritten));
    EXPECT_EQ(ask(kOne), Progress::kConcluded) << "a client that lost it asks again";
    EXPECT_FALSE(step()) << "and that is no new request";
}

TEST_F(Terminal, whole_numbers_keep_their_sign) {
    ask(kOther);
    const auto request = step();
    ASSERT_TRUE(request);
    EXPECT_EQ(request->int_value, -2);
    const ParameterValue value = answer_to(*request, -2.0F);
    step(&value);
    EXPECT_EQ(ask(kOther), Progress::kConcluded);
    EXPECT_EQ(answer.value, 0xFFFFFFFE);
}

TEST_F(Terminal, the_same_again_with_another_tag_is_a_new_request) {
    ask(kOne);
    const auto request = step();
    const ParameterValue value = answer_to(*request, 1.5F);
    step(&value);
    ParameterBox::Ask again = kOne;
    again.tag = 101;
    EXPECT_EQ(ask(again), Progress::kPending);
    EXPECT_TRUE(step());
}

TEST_F(Terminal, a_second_client_waits_for_the_first) {
    ask(kOne);
    EXPECT_EQ(ask(kOther), Progress::kBusy);
    const auto request = step();
    EXPECT_EQ(ask(kOther), Progress::kBusy);
    const ParameterValue value = answer_to(*request, 1.5F);
    step(&value);
    EXPECT_EQ(ask(kOther), Progress::kPending);
    const auto next = step();
    ASSERT_TRUE(next);
    EXPECT_EQ(next->index, 3);
}

TEST_F(Terminal, answers_to_others_are_not_ours) {
    ask(kOne);
    const auto request = step();
    ParameterValue value = answer_to(*request, 1.5F);
    value.requester = ParameterValue::Requester::kCan;
    step(&value);
    EXPECT_EQ(ask(kOne), Progress::kPending);
    value = answer_to(*request, 1.5F);
    ++value.tag;
    step(&value);
    EXPECT_EQ(ask(kOne), Progress::kPending);
}

TEST_F(Terminal, a_graph_that_does_not_answer_ends_the_request) {
    ask(kOne);
    const auto request = step();
    for (int i = 0; i < 100; ++i) step();
    EXPECT_EQ(ask(kOne), Progress::kConcluded);
    EXPECT_EQ(answer.result, ParameterBox::kNoAnswer);
    EXPECT_EQ(ask(kOther), Progress::kPending);
    EXPECT_TRUE(step());
    const ParameterValue late = answer_to(*request, 1.5F);
    step(&late);
    EXPECT_EQ(ask(kOther), Progress::kPending) << "a late answer belongs to nobody";
}

// As docs/link.md describes the bytes.
TEST_F(Terminal, the_link_carries_requests) {
    const Bytes request{5, 42, 7, 0, 100, 0, kSet, kFloat, 0, 0, 0xC0, 0x3F};
    Bytes body(64);
    const auto put = [&](ParameterBox* box, const Bytes& bytes) {
        Writer out(body.data());
        return put_parameter(out, box, bytes.data(), bytes.size()) ? out.count() : 0;
    };
    EXPECT_EQ(put(nullptr, request), 6U);
    EXPECT_EQ(body[0], static_cast<uint8_t>(Progress::kUnserved));
    EXPECT_EQ(put(&device.box, request), 6U);
    EXPECT_EQ(body[0], static_cast<uint8_t>(Progress::kPending));
    const auto published = step();
    ASSERT_TRUE(published);
    EXPECT_EQ(published->index, 7);
    EXPECT_EQ(published->float_value, 1.5F);
    const ParameterValue value = answer_to(*published, 1.5F);
    step(&value);
    put(&device.box, request);
    EXPECT_EQ(Bytes(body.begin(), body.begin() + 6), (Bytes{3, 1, 0, 0, 0xC0, 0x3F}));
    for (const size_t count : {size_t{4}, size_t{11}, size_t{13}}) {
        Bytes wrong = request;
        wrong.resize(count);
        EXPECT_EQ(put(&device.box, wrong), 0U) << count;
    }
}

}  // namespace
}  // namespace stator::drivers::terminal::box
