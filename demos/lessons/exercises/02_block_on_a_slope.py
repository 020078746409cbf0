# %% [markdown]
# **1.** A slope of exactly $\mu = 0.5$: does it stay? What is its speed after 1 s? Reach
# **0.000000** m/s.

# %%
answer = slide(0.5)["v"][-1]

# %% [markdown]
# **2.** How long does the block take from rest to slide one metre down a slope of 0.8? Exactly
# $\sqrt{2/a}$. Run until 1 s and read when it passes. Reach **0.933** s.

# %%
down = slide(0.8, dt=0.001)
answer = np.interp(1.0, down["x"] - down["x"][0], down.time)

# %% [markdown]
# **3.** Make the regularised law sharper, $v_0 = 0.001$ m/s. How far has the block crept after 3 s?
# It never stops creeping: the distance is in proportion to $v_0$. Reach **0.0033** m.


# %%
class Sharper(Regularised):
    def bound(self, k, pressure, S):
        return mu * ufl.tanh(k.slip_speed / 0.001) * pressure


sharper = slide(0.4, friction=Sharper(), until=3.0)
answer = sharper["x"][-1] - sharper["x"][0]
