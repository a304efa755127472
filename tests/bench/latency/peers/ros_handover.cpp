// The same from process to process with ROS 1: `ros_handover SAMPLES`, with a master. Built by
// `./stator bench latency` where libroscpp-dev is installed.
#include <ros/ros.h>
#include <std_msgs/String.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "../measured.hpp"

namespace {

constexpr char kTopic[] = "sample";

struct Shared {
    uint64_t received;
    measured::Row rows[1];  // and more behind
};
Shared* shared = nullptr;

void take(const std_msgs::String::ConstPtr& message) {
    measured::Sample sample;
    std::memcpy(&sample, message->data.data(), sizeof sample);
    shared->rows[sample.value[0]].latency_ns =
        static_cast<uint32_t>(measured::now_ns() - sample.sent_ns);
    ++shared->received;
}

void receive(int count, char** arguments) {
    ros::init(count, arguments, "sink", ros::init_options::NoSigintHandler);
    ros::NodeHandle node;
    const ros::Subscriber subscriber =
        node.subscribe(kTopic, 10, take, ros::TransportHints().tcpNoDelay());
    ros::spin();
}

void send(int count, char** arguments, uint64_t samples) {
    ros::init(count, arguments, "source", ros::init_options::NoSigintHandler);
    ros::NodeHandle node;
    const ros::Publisher publisher = node.advertise<std_msgs::String>(kTopic, 10);
    while (publisher.getNumSubscribers() == 0) usleep(10'000);
    uint64_t due_ns = measured::now_ns();
    for (uint64_t i = 0; i < samples; ++i) {
        due_ns += measured::kPeriod_ns;
        measured::sleep_until(due_ns);
        const uint64_t begin_ns = measured::now_ns();
        measured::Sample sample;
        sample.sent_ns = begin_ns;
        sample.value[0] = i;
        std_msgs::String message;
        message.data.assign(reinterpret_cast<const char*>(&sample), sizeof sample);
        publisher.publish(message);
        shared->rows[i].call_ns = static_cast<uint32_t>(measured::now_ns() - begin_ns);
    }
    usleep(200'000);  // the last ones arrive
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) return 2;
    const uint64_t samples = std::strtoul(arguments[1], nullptr, 10);
    const size_t bytes = sizeof(Shared) + samples * sizeof(measured::Row);
    shared = static_cast<Shared*>(
        mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
    const pid_t receiver = fork();
    if (receiver == 0) {
        receive(count, arguments);
        _exit(0);
    }
    send(count, arguments, samples);
    kill(receiver, SIGKILL);
    waitpid(receiver, nullptr, 0);
    for (uint64_t i = 0; i < samples; ++i) measured::print(shared->rows[i]);
    return shared->received == 0 ? 1 : 0;
}
