/* State of a disk: the files and names that it holds, and the rest after a power cut. In: every call that changed something, from
 * preload.c. Out: the folder as it is after the cut.
 */
#define MOST_FILES 8192
#define MOST_CHANGES 65536

/* Bytes of a file that are on the disk. */
struct file {
    dev_t device;
    ino_t number;
    off_t durable;
    /* A sync failed; later ones do not write these bytes to the disk (as on Linux since 4.13). */
    int poisoned;
};

/* Change of names that is not on the disk yet. */
struct change {
    enum { CREATED, MADE_FOLDER, RENAMED, UNLINKED, REMOVED_FOLDER } what;
    char *name, *from, *saved;
};

static struct file files[MOST_FILES];
static struct change changes[MOST_CHANGES];
static long file_count, change_count, saved_count;

static struct file *file_of(const struct stat *about) {
    for (long i = 0; i < file_count; i++)
        if (files[i].number == about->st_ino && files[i].device == about->st_dev) return &files[i];
    return NULL;
}

/* Returns the state of a file. At its first use, an existing file is on the disk as it is, a new one with none of its bytes. */
static struct file *know(int fd, int is_new) {
    struct stat about;
    if (fstat(fd, &about) || !S_ISREG(about.st_mode)) return NULL;
    struct file *file = file_of(&about);
    if (!file) {
        if (file_count == MOST_FILES) stop("too many files", "");
        file = &files[file_count++];
        *file = (struct file){about.st_dev, about.st_ino, about.st_size, 0};
    }
    if (is_new) *file = (struct file){about.st_dev, about.st_ino, 0, 0};
    return file;
}

static void changed(int what, const char *name, const char *from, const char *saved) {
    if (change_count == MOST_CHANGES) stop("too many changes", name);
    changes[change_count++] = (struct change){what, strdup(name), from ? strdup(from) : NULL, saved ? strdup(saved) : NULL};
}

/* Keeps the file of this name under another name beside the root; returns null if there is no such file. */
static const char *save(const char *name, char *place) {
    snprintf(place, PATH_MAX, "%.4000s/%d-%ld", side, getpid(), saved_count++);
    return linkat(AT_FDCWD, name, AT_FDCWD, place, 0) ? NULL : place;
}

static int is_parent(const char *folder, const char *path) {
    const char *slash = strrchr(path, '/');
    return slash && (size_t)(slash - path) == strlen(folder) && !strncmp(folder, path, slash - path);
}

/* A folder was synced: its names are on the disk, and the names that files in it had before they got these. */
static void folder_synced(const char *folder) {
    long kept = 0;
    for (long i = 0; i < change_count; i++) {
        struct change change = changes[i];
        if (!is_parent(folder, change.name)) { changes[kept++] = change; continue; }
        size_t length = change.what == RENAMED ? strlen(change.from) : 0;
        for (long j = 0; length && j < kept; j++) {
            char *name = changes[j].name, moved[PATH_MAX];
            if (strncmp(name, change.from, length) || name[length] != '/') continue;
            snprintf(moved, sizeof moved, "%s%s", change.name, name + length);
            changes[j].name = strdup(moved);
        }
    }
    change_count = kept;
}

static uint64_t chance;

static uint64_t draw(uint64_t below_this) {
    chance += 0x9e3779b97f4a7c15ULL;
    uint64_t z = chance;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return (z ^ (z >> 31)) % below_this;
}

static int removed(const char *path, const struct stat *about, int what, struct FTW *at) {
    (void)about; (void)what; (void)at;
    return remove(path);
}

/* Writes zeros in the place of one sector, as if all other sectors had reached the disk first. */
static int lose_sector(const char *path, off_t from, off_t lost) {
    char zeros[512] = {0};
    off_t first = from + draw(lost), begin = first - first % 512, end = begin + 512;
    if (begin < from) begin = from;
    if (end > from + lost) end = from + lost;
    int fd = open(path, O_WRONLY);
    if (fd < 0 || pwrite(fd, zeros, end - begin, begin) < 0) stop("no sector", path);
    return close(fd);
}

/* Treats the bytes of a file that were not synced: they are gone, partly there, or replaced by zeros as a whole or in one sector. */
static int cut(const char *path, const struct stat *about, int what, struct FTW *at) {
    (void)at;
    struct file *file = what == FTW_F ? file_of(about) : NULL;
    if (!file || about->st_size <= file->durable) return 0;
    off_t lost = about->st_size - file->durable;
    switch (chance ? draw(5) : 0) {
    case 0:
        return truncate(path, file->durable);
    case 1:
        return truncate(path, file->durable + draw(lost + 1));
    case 2:
        return truncate(path, file->durable) || truncate(path, about->st_size);
    default:
        return lose_sector(path, file->durable, lost);
    }
}

static void power(uint64_t seed) {
    chance = seed;
    long keep = !seed || draw(2) ? 0 : draw(change_count + 1);
    while (change_count > keep) {
        struct change *change = &changes[--change_count];
        switch (change->what) {
        case CREATED: unlink(change->name); break;
        case MADE_FOLDER: nftw(change->name, removed, 8, FTW_DEPTH | FTW_PHYS); break;
        case RENAMED:
            rename(change->name, change->from);
            if (change->saved && linkat(AT_FDCWD, change->saved, AT_FDCWD, change->name, 0)) stop("not undone", change->name);
            break;
        case UNLINKED:
            if (change->saved) linkat(AT_FDCWD, change->saved, AT_FDCWD, change->name, 0);
            break;
        case REMOVED_FOLDER: mkdir(change->name, 0700); break;
        }
    }
    nftw(root, cut, 8, FTW_PHYS);
}
