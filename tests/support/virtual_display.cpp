#include "support/virtual_display.h"

#include <csignal>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace parhelion::testing {

namespace {

// An X server without a screen, on a number of its own choice.
class VirtualDisplay {
public:
    VirtualDisplay() {
        int ends[2];
        if (pipe(ends) != 0) return;
        process_ = fork();
        if (process_ == 0) {
            const std::string number = std::to_string(ends[1]);
            const int nothing = open("/dev/null", O_RDWR);
            dup2(nothing, 1);
            dup2(nothing, 2);
            close(ends[0]);
            execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "640x480x24", "-nolisten", "tcp", static_cast<char*>(nullptr));
            _exit(127);
        }
        close(ends[1]);
        // It writes its number once it takes clients; an end without one: it is not installed.
        char letter = 0;
        while (read(ends[0], &letter, 1) == 1 && letter != '\n') name_ += letter;
        close(ends[0]);
        if (!name_.empty()) name_.insert(0, ":");
    }
    ~VirtualDisplay() {
        if (process_ <= 0) return;
        kill(process_, SIGTERM);
        waitpid(process_, nullptr, 0);
    }
    VirtualDisplay(const VirtualDisplay&) = delete;
    VirtualDisplay& operator=(const VirtualDisplay&) = delete;
    const std::string& name() const { return name_; }  // empty: there is none

private:
    pid_t process_ = -1;
    std::string name_;
};

}  // namespace

const std::string& virtual_display() {
    static const VirtualDisplay shared;
    return shared.name();
}

}  // namespace parhelion::testing
