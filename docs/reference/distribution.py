# %% setting
import usdsdg as rep

boxes = rep.create.cube(count=3)

# %% uniform
with rep.trigger.on_frame(), boxes:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 2)), scale=rep.distribution.uniform(0.5, 1))

# %% normal
with rep.trigger.on_frame(), boxes:
    rep.modify.pose(position=rep.distribution.normal((0, 0, 1), (0.5, 0.5, 0.1)))

# %% log_uniform
# As many lamps between 1,000 and 10,000 nits as between 10,000 and 100,000.
lamp = rep.create.light(light_type="Sphere", intensity=rep.distribution.log_uniform(1_000, 100_000))

# %% choice
with rep.trigger.on_frame(), boxes:
    rep.randomizer.color(colors=rep.distribution.choice([(1, 0, 0), (0, 0, 1)], weights=[1, 3]))

# %% sequence
with rep.trigger.on_frame(), boxes:
    # The first box has 0.2, 0.8, 0.4, ...: each takes the next one, and frames go on where the last ended.
    rep.modify.pose(scale=rep.distribution.sequence([0.2, 0.4, 0.6, 0.8], stride=3))

# %% combine
with rep.trigger.on_frame(), boxes:
    height = rep.distribution.choice([0.0, 0.5, 1.0])
    side = rep.distribution.uniform(-1, 1)
    rep.modify.pose(position=rep.distribution.combine([side, rep.distribution.normal(0, 0.1), height]))


# %% register
def jitter(amount):
    return rep.distribution.uniform((-amount,) * 3, (amount,) * 3)


rep.distribution.register(jitter)
with rep.trigger.on_frame(), boxes:
    rep.modify.pose(position=rep.distribution.jitter(0.01))
