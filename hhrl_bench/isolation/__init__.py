"""Users' agents in processes of their own: what is said to them, what they may do, and how they end."""
