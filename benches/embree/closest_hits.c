/* Embree's single rays on a scene and rays that benches/hits.rs wrote; compares its hits with ours.
   closest_hits FILE fast|robust   prints: rays/s hits differing bytes seconds_to_build */

#include <embree3/rtcore.h>
#include <math.h>
#include <pmmintrin.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <xmmintrin.h>

/* One ray of the file and the answer to it; `placement` is UINT32_MAX if it meets nothing. */
struct Query {
    float origin[3], direction[3], t_max;
    float t;
    uint32_t placement, triangle;
};

static void* read_all(FILE* file, size_t bytes) {
    void* data = aligned_alloc(64, (bytes + 127) / 64 * 64);
    if (!data || fread(data, 1, bytes, file) != bytes) {
        fprintf(stderr, "the file is cut off\n");
        exit(1);
    }
    return data;
}

static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

static ssize_t allocated = 0;
static bool count(void* unused, ssize_t bytes, bool post) {
    (void)unused, (void)post;
    __atomic_add_fetch(&allocated, bytes, __ATOMIC_RELAXED);
    return true;
}

int main(int argc, char** argv) {
    FILE* file = argc == 3 ? fopen(argv[1], "rb") : NULL;
    if (!file) {
        fprintf(stderr, "usage: closest_hits FILE fast|robust\n");
        return 1;
    }
    enum RTCSceneFlags flags =
        strcmp(argv[2], "robust") == 0 ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE;
    /* As Embree's manual asks of every program that traces. */
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    uint32_t* head = read_all(file, 12);
    uint32_t meshes = head[0], placements = head[1], queries = head[2];

    RTCDevice device = rtcNewDevice("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device, count, NULL);
    double start = cpu_seconds();
    RTCScene* prototypes = malloc(meshes * sizeof *prototypes);
    for (uint32_t i = 0; i < meshes; i++) {
        uint32_t* sizes = read_all(file, 8);
        float* vertices = read_all(file, 12 * (size_t)sizes[0]);
        uint32_t* triangles = read_all(file, 12 * (size_t)sizes[1]);
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0,
                                   12, sizes[0]);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles, 0,
                                   12, sizes[1]);
        rtcSetGeometryBuildQuality(mesh, RTC_BUILD_QUALITY_HIGH);
        rtcCommitGeometry(mesh);
        prototypes[i] = rtcNewScene(device);
        rtcSetSceneFlags(prototypes[i], flags);
        rtcSetSceneBuildQuality(prototypes[i], RTC_BUILD_QUALITY_HIGH);
        rtcAttachGeometry(prototypes[i], mesh);
        rtcCommitScene(prototypes[i]);
    }
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, flags);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    for (uint32_t i = 0; i < placements; i++) {
        uint32_t* mesh = read_all(file, 4);
        float* columns = read_all(file, 48);
        RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, prototypes[*mesh]);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
        rtcCommitGeometry(instance);
        rtcAttachGeometryByID(scene, instance, i);
    }
    rtcCommitScene(scene);
    double built = cpu_seconds() - start;
    struct Query* query = read_all(file, queries * sizeof *query);

    uint32_t hits = 0, differing = 0;
    start = cpu_seconds();
    for (uint32_t i = 0; i < queries; i++) {
        struct Query* q = &query[i];
        struct RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        struct RTCRayHit r = {
            .ray = {.org_x = q->origin[0], .org_y = q->origin[1], .org_z = q->origin[2],
                    .dir_x = q->direction[0], .dir_y = q->direction[1], .dir_z = q->direction[2],
                    .tnear = 0, .tfar = q->t_max, .mask = UINT32_MAX},
            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
        rtcIntersect1(scene, &context, &r);
        hits += r.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        int same = r.hit.instID[0] == q->placement &&
                   (q->placement == UINT32_MAX || r.hit.primID == q->triangle);
        /* Single precision: a hundredth of a micrometre on a bed of some millimetres. */
        differing += !same && !(q->placement != UINT32_MAX && fabsf(r.ray.tfar - q->t) < 0.01f);
    }
    double seconds = cpu_seconds() - start;
    printf("%.1f %u %u %zd %.4f\n", queries / seconds, hits, differing, allocated, built);
    return 0;
}
