// The link of a graph that runs: who asks is answered, and whoever does not behave costs nothing.
// Clients live in the thread that serves them, so that each step is one turn.
#include "stator/link.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "program.hpp"
#include "stator/answers.hpp"

namespace stator {
namespace {

using Bytes = std::vector<uint8_t>;

class LinkTest : public ::testing::Test {
  protected:
    LinkTest() {
        char name[] = "/tmp/stator-link-XXXXXX";
        folder_ = mkdtemp(name);
        path_ = folder_ + "/link";
    }
    ~LinkTest() override {
        EXPECT_TRUE(!started_ || finish());
        EXPECT_NE(access(path_.c_str(), F_OK), 0) << "finish removes it";
        rmdir(folder_.c_str());
    }
    void begin(double speed = 1.0) {
        ASSERT_TRUE(offer_link(path_.c_str()));
        ASSERT_TRUE(testing::start_unhurried(speed));
        started_ = true;
    }
    static void serve_for(uint64_t time_us) { wait_until(clock_us() + time_us); }

    std::string folder_;
    std::string path_;
    bool started_ = false;
};

Bytes request(Request kind, uint8_t tag, uint8_t argument = 0) {
    Bytes body{static_cast<uint8_t>(kind), tag, argument, 0};
    const size_t count = body.size();
    body.resize(count + kCrcBytes);
    Bytes frame(frame_bytes(count));
    frame.resize(write_frame(body.data(), count, frame.data()));
    return frame;
}

sockaddr_un address_of(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::snprintf(address.sun_path, sizeof address.sun_path, "%s", path.c_str());
    return address;
}

class Asker {
  public:
    explicit Asker(const std::string& path)
        : socket_(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0)) {
        const sockaddr_un address = address_of(path);
        EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    ~Asker() { ::close(socket_); }
    Asker(const Asker&) = delete;
    Asker& operator=(const Asker&) = delete;

    // How many bytes the socket took.
    size_t send(const Bytes& bytes) const {
        const ssize_t count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        return count < 0 ? 0 : static_cast<size_t>(count);
    }
    // The next answer; empty: none within `most_us`.
    Bytes answer(uint64_t most_us = testing::kForever_us) {
        for (const uint64_t end_us = clock_us() + most_us; clock_us() < end_us;) {
            uint8_t byte = 0;
            const ssize_t count = recv(socket_, &byte, 1, 0);
            has_ended_ = has_ended_ || count == 0;
            if (count < 0) wait_until(clock_us() + 1000);
            if (has_ended_) break;
            if (count == 1 && reader_.take(byte)) {
                return {reader_.body(), reader_.body() + reader_.count()};
            }
        }
        return {};
    }
    bool is_answered(uint8_t tag) {
        if (send(request(Request::kInfo, tag)) == 0) return false;
        const Bytes body = answer();
        return body.size() > 2 && body[0] == static_cast<uint8_t>(Request::kInfo) && body[1] == tag;
    }
    bool has_ended() const { return has_ended_; }

  private:
    int socket_;
    FrameReader<Link::kMaxAnswer> reader_;
    bool has_ended_ = false;
};

TEST_F(LinkTest, tells_of_every_task) {
    std::atomic<uint64_t> runs{0};
    testing::jobs[4] = [&] { ++runs; };
    begin();
    Asker asker(path_);
    ASSERT_TRUE(asker.is_answered(7));
    asker.send(request(Request::kTasks, 8));
    // Kind, tag, time, first, and seven figures a task.
    EXPECT_EQ(asker.answer().size(), 2U + 8 + 2 + testing::kTasks * 28);
    EXPECT_TRUE(testing::wait_for([&] { return runs > 3; }));
}

TEST_F(LinkTest, says_nothing_to_what_is_no_request) {
    begin();
    Asker asker(path_);
    for (const uint8_t kind : Bytes{0, 4, 9, 255}) asker.send(request(Request{kind}, 1));
    asker.send(request(Request::kSample, 2));  // the program has no topic
    asker.send(Bytes(100, 0xAA));
    asker.send({0});
    EXPECT_TRUE(asker.is_answered(3));
}

TEST_F(LinkTest, serves_several_at_once_and_whoever_comes_after_them) {
    begin();
    std::vector<std::unique_ptr<Asker>> askers;
    for (uint8_t i = 0; i < 8; ++i) {
        askers.push_back(std::make_unique<Asker>(path_));
        ASSERT_TRUE(askers.back()->is_answered(i));
    }
    ASSERT_TRUE(askers[0]->is_answered(10));
    // One more than there is room for: who was silent the longest goes.
    Asker late(path_);
    EXPECT_TRUE(late.is_answered(20));
    EXPECT_TRUE(askers[0]->is_answered(21));
    EXPECT_FALSE(askers[1]->is_answered(22));
    EXPECT_EQ(askers[1]->answer(), Bytes{});
    EXPECT_TRUE(askers[1]->has_ended());
}

// Whoever looks lives in the machine's time: in a second of it there are many turns, also where a
// millisecond passes for the graph.
TEST_F(LinkTest, a_slower_clock_does_not_slow_answers) {
    begin(0.001);
    Asker asker(path_);
    constexpr uint8_t kRequests = 8;  // some turns of 32 bytes
    for (uint8_t i = 0; i < kRequests; ++i) asker.send(request(Request::kInfo, i));
    serve_for(1000);
    for (uint8_t i = 0; i < kRequests; ++i) {
        const Bytes body = asker.answer(900);  // it is there, or waited for once
        ASSERT_GT(body.size(), 2U) << "answer " << int{i};
        EXPECT_EQ(body[1], i);
    }
}

// Thousands of requests, of which no answer is read; and bytes that never end a frame.
TEST_F(LinkTest, whoever_never_reads_holds_nobody_up) {
    begin();
    Asker deaf(path_);
    Asker mad(path_);
    Bytes many;
    for (int i = 0; i < 100; ++i) {
        const Bytes one = request(Request::kTasks, 1);
        many.insert(many.end(), one.begin(), one.end());
    }
    const Bytes noise(1000, 0x55);
    for (int i = 0; i < 300; ++i) {
        deaf.send(many);
        mad.send(noise);
        serve_for(1000);
    }
    EXPECT_EQ(mad.answer(1), Bytes{});
    Asker asker(path_);
    EXPECT_TRUE(asker.is_answered(1));
    EXPECT_FALSE(deaf.answer().empty());
}

TEST_F(LinkTest, whoever_disappears_leaves_nothing) {
    begin();
    for (int i = 0; i < 50; ++i) {
        Asker asker(path_);
        asker.send(request(Request::kInfo, 1));
        if (i % 2 == 0) serve_for(10'000);  // else before it is accepted
    }
    Asker asker(path_);
    EXPECT_TRUE(asker.is_answered(2));
}

TEST_F(LinkTest, the_end_is_not_held_up_and_clients_see_it) {
    begin();
    Asker asker(path_);
    ASSERT_TRUE(asker.is_answered(1));
    EXPECT_EQ(wait_until(clock_us() + 10'000), Ending::kTime);
    EXPECT_TRUE(finish());
    started_ = false;
    EXPECT_FALSE(asker.is_answered(2));
}

TEST_F(LinkTest, a_socket_that_was_left_behind_is_replaced) {
    const sockaddr_un address = address_of(path_);
    const int left = socket(AF_UNIX, SOCK_STREAM, 0);
    ASSERT_EQ(bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(listen(left, 1), 0);
    ::close(left);
    begin();
    EXPECT_TRUE(Asker(path_).is_answered(1));
}

TEST_F(LinkTest, the_link_of_another_run_is_left_alone) {
    const sockaddr_un address = address_of(path_);
    const int other = socket(AF_UNIX, SOCK_STREAM, 0);
    ASSERT_EQ(bind(other, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(listen(other, 4), 0);
    ::testing::internal::CaptureStderr();
    EXPECT_FALSE(offer_link(path_.c_str()));
    EXPECT_NE(::testing::internal::GetCapturedStderr().find("another one's"), std::string::npos);
    const Asker still(path_);
    ::close(other);
    unlink(path_.c_str());
}

TEST_F(LinkTest, a_file_is_left_alone) {
    std::FILE* const file = std::fopen(path_.c_str(), "wb");
    std::fclose(file);
    EXPECT_FALSE(offer_link(path_.c_str()));
    struct stat now {};
    EXPECT_EQ(stat(path_.c_str(), &now), 0);
    EXPECT_TRUE(S_ISREG(now.st_mode));
    unlink(path_.c_str());
}

}  // namespace
}  // namespace stator
