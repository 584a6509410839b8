/* The plan of faults. In: lines of FAULTS_PLAN. Out: faults, in their order.
 */
#define MOST_FAULTS 16

enum action { FAIL, SHORT, SLOW, KILL, POWER, JUMP };

struct fault {
    char kind[16], name[128], what[32];
    long at, seen, number;
    enum action action;
    int error, stays, after;
};

static struct fault faults[MOST_FAULTS];
static int fault_count;

static const struct { const char *name; int number; } ERRORS[] = {
    {"EIO", EIO}, {"ENOSPC", ENOSPC}, {"EDQUOT", EDQUOT}, {"EACCES", EACCES}, {"EROFS", EROFS}, {"EINTR", EINTR},
    {"EMFILE", EMFILE}, {"ENOMEM", ENOMEM}, {"ESTALE", ESTALE}, {"ECONNREFUSED", ECONNREFUSED}, {"ECONNRESET", ECONNRESET},
    {"ETIMEDOUT", ETIMEDOUT}, {"EPIPE", EPIPE},
};

static void parse(char *line) {
    struct fault *fault = &faults[fault_count];
    char action[32];
    long number = 0;
    if (fault_count == MOST_FAULTS) stop("too many faults", line);
    int read = sscanf(line, "%15s %127s %ld %31s %ld", fault->kind, fault->name, &fault->at, action, &number);
    if (read < 4) stop("no fault", line);
    snprintf(fault->what, sizeof fault->what, "%s", action);
    fault->number = number;
    char *after = strstr(action, "-after");
    if (after) { fault->after = 1; *after = 0; }
    char *stays = strchr(action, '+');
    if (stays) { fault->stays = 1; *stays = 0; }
    if (!strcmp(action, "short")) fault->action = SHORT;
    else if (!strcmp(action, "slow")) fault->action = SLOW;
    else if (!strcmp(action, "kill")) fault->action = KILL;
    else if (!strcmp(action, "power")) fault->action = POWER;
    else if (!strcmp(action, "jump")) fault->action = JUMP;
    else {
        for (unsigned i = 0; i < sizeof ERRORS / sizeof *ERRORS; i++)
            if (!strcmp(action, ERRORS[i].name)) fault->error = ERRORS[i].number;
        if (!fault->error) stop("no action", line);
    }
    fault_count++;
}
