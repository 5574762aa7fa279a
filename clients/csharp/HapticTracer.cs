// Haptic tracing by itself: the graph of what touches, best paths, mix. What touches and what hits is told by the engine.
// One file for .NET Standard 2.0 (Unity 2021 and later), without dependencies; a step allocates nothing once it has run.
// The tables are those of NAME.tracer.json (docs/tracer.md), or are made in code.

using System;
using System.Collections.Generic;
using System.Globalization;
using System.Text.RegularExpressions;

namespace HapticTracer
{
    public struct Vector
    {
        public double X, Y, Z;

        public Vector(double x, double y, double z) { X = x; Y = y; Z = z; }

        public double Dot(Vector v) { return X * v.X + Y * v.Y + Z * v.Z; }
        public static Vector operator +(Vector a, Vector b) { return new Vector(a.X + b.X, a.Y + b.Y, a.Z + b.Z); }
        public static Vector operator -(Vector a, Vector b) { return new Vector(a.X - b.X, a.Y - b.Y, a.Z - b.Z); }
        public static Vector operator *(Vector v, double factor) { return new Vector(v.X * factor, v.Y * factor, v.Z * factor); }
    }

    /// <summary>What a connection costs, -log of its gain, in each lane: without bands, then by band if there are any.</summary>
    public sealed class Function
    {
        internal double[] Loss, Decay, Grid, Costs, Spring;
        internal double Exponent, Reference = 1, Extent = 1, Width = 1, Over, Point = double.PositiveInfinity, Range, Slowness;
        internal string Variable;

        public Function(double loss, double decay, int lanes = 1)
        {
            Loss = new double[lanes];
            Decay = new double[lanes];
            for (var lane = 0; lane < lanes; lane++) { Loss[lane] = loss; Decay[lane] = decay; }
        }

        internal Function() { }

        /// <summary>K exp(-max(K, epsilon) d) with K = (1 - kappa) rho.</summary>
        public static Function Paper(double kappa, double rho, int lanes = 1)
        {
            var k = (1 - kappa) * rho;
            return new Function(-Math.Log(k), Math.Max(k, 0.1), lanes);
        }

        /// <summary>Of another form than a metric plus a constant, so that an object may be entered again at any cost.</summary>
        internal bool IsSpecial { get { return Range > 0 || Costs != null; } }

        internal double Spread(double run)
        {
            if (Exponent == 0) return 0;
            return run > Extent
                ? Exponent * Math.Log(1 + Extent / Reference) + 0.5 * Math.Log(1 + (run - Extent) / Width)
                : Exponent * Math.Log(1 + run / Reference);
        }

        /// <summary>What is alike in all lanes over a distance between fronts of waves that have run some way before.</summary>
        internal double Shape(double distance, double value, double one, double other, double halves)
        {
            var cost = one == 0 && other == 0
                ? Spread(distance < Over ? distance : Over)
                : Math.Max(Spread(Math.Max(Math.Max(one, other), Math.Min(distance + (one + other) / 2, Over))) - halves, 0);
            return IsSpecial ? cost + Special(distance, value) : cost;
        }

        double Special(double distance, double value)
        {
            var cost = Range == 0 ? 0 : distance < Range ? -Math.Log(1 - distance / Range) : double.PositiveInfinity;
            if (Costs == null || double.IsNaN(value)) return cost;
            var place = Array.BinarySearch(Grid, value);
            if (place < 0) place = Math.Min(~place, Grid.Length - 1);
            if (place == 0) return cost + Costs[0];
            var share = (Math.Min(value, Grid[place]) - Grid[place - 1]) / (Grid[place] - Grid[place - 1]);
            var sampled = Costs[place - 1] + share * (Costs[place] - Costs[place - 1]);
            return sampled < 14 ? cost + sampled : double.PositiveInfinity;
        }
    }

    /// <summary>A body by whose impedance contacts pass on. Its arrays are by frequency band.</summary>
    sealed class Body
    {
        internal int Kind;
        internal double[] Mobility, Flexible, HalfSpace, Spring;

        /// <summary>Whether it moves with what stands behind it, as far as it is stiff.</summary>
        internal bool Carries { get { return Flexible != null; } }

        /// <summary>The mobility of a half-space under a patch.</summary>
        internal double At(double omega, double area)
        {
            var driven = HalfSpace[0] + area / Math.PI;
            double damper = HalfSpace[2] * driven, spring = HalfSpace[1] * Math.Sqrt(driven) / omega;
            return 1 / Math.Sqrt(damper * damper + spring * spring);
        }
    }

    /// <summary>An object that vibration runs through.</summary>
    public sealed class TracedObject
    {
        public string Name = "";
        public Function Function;
        /// <summary>Its class in the tables of contacts and blows, and its mass in kilograms, 0 if nothing moves it.</summary>
        public int Class;
        public double Mass;
        internal Body Body;
        internal Vector Centre = new Vector(double.NaN, 0, 0), Size = new Vector(double.NaN, 0, 0), Place;
        internal Vector X = new Vector(1, 0, 0), Y = new Vector(0, 1, 0), Z = new Vector(0, 0, 1);
        internal Node[] Nodes = new Node[4];
        internal int Count;
        /// <summary>Whether it moves with what stands behind it, and in which rounds that changes: bits.</summary>
        internal bool Carries;
        internal int Due;
        /// <summary>Those which it touches where the file says.</summary>
        internal readonly List<TracedObject> Joined = new List<TracedObject>();

        /// <summary>Where it is: position and rotation.</summary>
        public void Move(double x, double y, double z, double qw, double qx, double qy, double qz)
        {
            Place = new Vector(x, y, z);
            X = new Vector(1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qw * qz), 2 * (qx * qz - qw * qy));
            Y = new Vector(2 * (qx * qy - qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qw * qx));
            Z = new Vector(2 * (qx * qz + qw * qy), 2 * (qy * qz - qw * qx), 1 - 2 * (qx * qx + qy * qy));
        }

        /// <summary>What a patch with this normal fills per area: the inverse of its width.</summary>
        internal double Across(Vector normal)
        {
            if (double.IsNaN(Size.X)) return 0;
            double a = normal.Dot(X), b = normal.Dot(Y), c = normal.Dot(Z);
            return a * a / Math.Max(Math.Min(Size.Y, Size.Z), 0.01) + b * b / Math.Max(Math.Min(Size.Z, Size.X), 0.01) + c * c / Math.Max(Math.Min(Size.X, Size.Y), 0.01);
        }

        internal double Middle { get { return double.IsNaN(Size.X) ? double.PositiveInfinity : Math.Max(Math.Min(Size.X, Size.Y), Math.Min(Math.Max(Size.X, Size.Y), Size.Z)); } }

        internal Vector Turned(Vector v) { return X * v.X + Y * v.Y + Z * v.Z; }
        public Vector ToWorld(Vector local) { return Place + Turned(local); }
        public Vector ToLocal(Vector world)
        {
            var from = world - Place;
            return new Vector(from.Dot(X), from.Dot(Y), from.Dot(Z));
        }

        internal Node Add(Vector at, int lanes, Contact contact = null)
        {
            if (Count == Nodes.Length) Array.Resize(ref Nodes, 2 * Count);
            var node = Nodes[Count] ?? (Nodes[Count] = new Node { Owner = this, Crossing = new double[lanes] });
            Count++;
            node.X = at.X;
            node.Y = at.Y;
            node.Z = at.Z;
            node.Contact = contact;
            node.Partner = null;
            node.Reach = node.Run = node.Half = 0;
            node.Listens = node.ByBodies = node.Carried = false;
            for (var lane = 0; lane < lanes; lane++) node.Crossing[lane] = double.NaN;
            return node;
        }
    }

    /// <summary>A node of the graph.</summary>
    sealed class Node
    {
        internal TracedObject Owner;
        internal Contact Contact;
        internal Node Partner, Entry;
        internal double X, Y, Z, Reach, Run, Half, Arrival;
        internal bool Listens, Settled;
        // Of leaving over its contact: by lane the cost, NaN if it is not known yet; whether it is by bodies, and by what stands
        // behind these; by band the mobility of the body alone, and as it carries others; what of that is being computed.
        internal double[] Crossing;
        internal bool ByBodies, Carried;
        internal readonly double[] Alone = new double[6], Mobility = new double[6], Before = new double[6];
        internal double Opening, Give, Aside;

        internal double Distance(Node other)
        {
            double x = X - other.X, y = Y - other.Y, z = Z - other.Z;
            var apart = Math.Sqrt(x * x + y * y + z * z) - Reach - other.Reach;
            return apart > 0 ? apart : 0;
        }

        /// <summary>What is alike in all lanes over a distance to another node of the object.</summary>
        internal double Shape(Node other, double distance) { return Owner.Function.Shape(distance, distance, Run, other.Run, Half + other.Half); }
    }

    /// <summary>A signal as rows of samples, each heard with a mix of the gains of the lanes.</summary>
    public sealed class Signal
    {
        public float[][] Rows;
        public bool Loops;
        internal int Lane;
        internal double[][] Mix, Power;

        public Signal(float[] samples, bool loops)
        {
            Rows = new[] { samples };
            Loops = loops;
            Mix = Power = new[] { new[] { 1.0 } };
        }

        internal Signal() { }

        /// <summary>A tone of whole hertz, endless, or fading within some seconds.</summary>
        public static Signal Tone(int frequency, double decay = double.PositiveInfinity, int rate = 8000)
        {
            var endless = double.IsPositiveInfinity(decay);
            var samples = new float[endless ? rate : (int)(8 * decay * rate)];
            for (var i = 0; i < samples.Length; i++)
                samples[i] = (float)(Math.Sin(2 * Math.PI * frequency * i / rate) * Math.Exp(-i / (decay * rate)));
            return new Signal(samples, endless);
        }

        /// <summary>The gain of the whole signal by the gains of the lanes from a place in them on.</summary>
        internal double Gain(double[] gains, int from)
        {
            var sum = 0.0;
            for (var i = 0; i < Power.Length; i++)
                for (var j = 0; j < Power.Length; j++)
                    sum += gains[from + i] * Power[i][j] * gains[from + j];
            return Math.Sqrt(Math.Max(sum, 0));
        }
    }

    /// <summary>What vibrates: always, or, where it plays once, whenever it is asked to.</summary>
    public sealed class Source
    {
        public string Name = "";
        /// <summary>Its object, and its position there.</summary>
        public TracedObject On;
        public Vector Position;
        public double Amplitude = 1;
        public bool Once;
        public Signal Signal;
        /// <summary>By listener: the objects on the best path, from here on.</summary>
        public List<TracedObject>[] Paths = new List<TracedObject>[0];
        internal TracedObject Second;
        internal Node Node, SecondNode;
        internal int Voices;
        internal Vector SecondPosition;
        internal bool Started, Began;
        // By listener: gains of lanes, and before and now those of rows with all factors, and delays in samples.
        internal double[] Gains, Before, Now, Late, Later;

        internal bool Sounds { get { return Amplitude > 0 && Voices > 0; } }

        /// <summary>The gain of its signal on the best path to a listener.</summary>
        public double Gain(int listener)
        {
            return Gains == null ? 0 : Signal.Gain(Gains, listener * (Gains.Length / Paths.Length));
        }

        internal void Fit(int listeners, int lanes)
        {
            if (Paths.Length == listeners && Gains != null && Gains.Length == listeners * lanes && Now.Length == listeners * Signal.Rows.Length) return;
            Paths = new List<TracedObject>[listeners];
            for (var l = 0; l < listeners; l++) Paths[l] = new List<TracedObject>();
            Gains = new double[listeners * lanes];
            Now = new double[listeners * Signal.Rows.Length];
            Before = new double[Now.Length];
            Late = new double[listeners];
            Later = new double[listeners];
        }
    }

    /// <summary>Where it is felt: a ball on an object.</summary>
    public sealed class Listener
    {
        public string Name = "", BodyPart = "";
        public TracedObject On;
        public Vector Position;
        public double Radius, Gain = 1, SMax = 1;
        /// <summary>The samples of the last step; there may be room for more behind them.</summary>
        public float[] Samples = new float[0];
        internal float[] Recent;
        internal double Sum, Energy;
        internal Node Node;
    }

    /// <summary>What a blow plays, by its strength.</summary>
    public sealed class Impact
    {
        public double LeastEnergy, FullEnergy = 100, WeakGain, FullGain = 1;
        public Signal[] Signals;
    }

    /// <summary>Two objects that touch. What is not known is left as it is: no area is a point.</summary>
    public sealed class Contact
    {
        public Vector At, OtherAt, Normal;
        public double Area, Depth, Force = double.NaN, Weight = 1;
        internal TracedObject One, Other;
        internal Node Node, OtherNode;
        internal int Number;
        internal Function Function;
        internal bool Stays;
        // Of one that stays: in the spaces of the objects.
        internal Vector Near, OtherNear, NormalNear;
    }

    struct Voice
    {
        internal Source Source;
        internal int Place;
    }

    /// <summary>The tracer. Tell what moves, touches and hits, then step; then listeners have samples and levels.</summary>
    public sealed class Tracer
    {
        /// <summary>The cost at which a search ends: -120 dB.</summary>
        const double Limit = 13.815510557964274;
        const int Bands = 6, Chain = 4, MostBlows = 32;
        const double Infinite = double.PositiveInfinity;

        public readonly int Lanes, SampleRate;
        public readonly List<TracedObject> Objects = new List<TracedObject>();
        public readonly List<Source> Sources = new List<Source>();
        public readonly List<Listener> Listeners = new List<Listener>();
        /// <summary>The blows that sound; the last ones have begun last.</summary>
        public readonly List<Source> Blows = new List<Source>();
        /// <summary>By the classes of two objects: what contacts pass on, and what blows play.</summary>
        public Function[][] Between;
        public Impact[][] Impacts;
        /// <summary>The number of samples of the last step.</summary>
        public int Count { get; private set; }

        readonly List<Contact> contacts = new List<Contact>();
        readonly Stack<Contact> spare = new Stack<Contact>();
        readonly Stack<Source> spareBlows = new Stack<Source>();
        readonly List<Voice> voices = new List<Voice>();
        readonly double[] omega = new double[Bands], best = new double[Bands], second = new double[Bands], costs;
        readonly int[] least = new int[Bands];
        TracedObject[] carrying = new TracedObject[0];
        int recentPlace, recentCount, carriers;
        double part;
        bool isSpecial;

        // A heap of entries.
        double[] keys = new double[64];
        Node[] values = new Node[64];
        int size;

        public Tracer(int lanes = 1, int sampleRate = 8000)
        {
            Lanes = lanes;
            SampleRate = sampleRate;
            costs = new double[lanes];
            Between = new[] { new[] { new Function(0, 0, lanes) } };
            Impacts = new[] { new[] { new Impact { LeastEnergy = 0.05, Signals = new[] { Signal.Tone(150, 0.03, sampleRate) } } } };
        }

        /// <summary>Two objects touch, until they part. Keep the contact up to date; null if the file says where they touch.</summary>
        public Contact Touch(TracedObject one, TracedObject other)
        {
            if (one.Joined.Contains(other)) return null;
            var added = spare.Count > 0 ? spare.Pop() : new Contact();
            added.Area = added.Depth = 0;
            added.Force = double.NaN;
            added.Weight = 1;
            added.One = one;
            added.Other = other;
            added.Function = Between[one.Class][other.Class];
            added.Number = contacts.Count;
            contacts.Add(added);
            return added;
        }

        /// <summary>Two objects touch no more.</summary>
        public void Part(Contact parted)
        {
            var last = contacts[contacts.Count - 1];
            contacts[last.Number = parted.Number] = last;
            contacts.RemoveAt(contacts.Count - 1);
            spare.Push(parted);
        }

        /// <summary>The energy in joules of a blow at a speed along the normal.</summary>
        public static double Energy(TracedObject one, TracedObject other, double speed)
        {
            var inverse = (one.Mass > 0 ? 1 / one.Mass : 0) + (other.Mass > 0 ? 1 / other.Mass : 0);
            return inverse > 0 ? speed * speed / (2 * inverse) : 0;
        }

        /// <summary>Two objects hit each other, some seconds after the next step's beginning. Whether it sounds: the blow is the last of Blows then.</summary>
        public bool Blow(TracedObject one, TracedObject other, Vector at, double energy, double after = 0)
        {
            var impact = Impacts[one.Class][other.Class];
            if (impact == null || energy < impact.LeastEnergy) return false;
            var strength = Math.Min(energy / impact.FullEnergy, 1);
            if (Blows.Count == MostBlows) Remove(Blows[0]);
            var blow = spareBlows.Count > 0 ? spareBlows.Pop() : new Source { Once = true };
            blow.Signal = impact.Signals[(int)Math.Round(strength * (impact.Signals.Length - 1))];
            blow.Amplitude = impact.WeakGain + (impact.FullGain - impact.WeakGain) * strength;
            blow.On = one;
            blow.Second = other;
            blow.Position = one.ToLocal(at);
            blow.SecondPosition = other.ToLocal(at);
            Blows.Add(blow);
            Play(blow, after);
            return true;
        }

        /// <summary>Play the signal of a source, some seconds after the next step's beginning.</summary>
        public void Play(Source source, double after = 0)
        {
            source.Started = true;
            source.Began = source.Voices++ == 0;
            voices.Add(new Voice { Source = source, Place = -(int)Math.Round(after * SampleRate) });
        }

        /// <summary>Go on by some seconds.</summary>
        public void Step(double seconds)
        {
            part += seconds * SampleRate;
            Count = (int)Math.Floor(part + 0.5);
            part -= Count;
            isSpecial = false;
            foreach (var item in Objects) isSpecial |= item.Function.IsSpecial;
            foreach (var source in Sources) if (!source.Once && !source.Started) Play(source);
            Number();
            PassOn();
            foreach (var source in Sources) Propagate(source);
            foreach (var blow in Blows) Propagate(blow);
            Mix();
        }

        /// <summary>The level of the last quarter second of a listener in decibels, NaN for silence.</summary>
        public double Level(int listener)
        {
            var felt = Listeners[listener];
            var energy = felt.Energy - felt.Sum * felt.Sum / (SampleRate / 4);
            return energy > 1e-10 * recentCount ? 10 * Math.Log10(energy / recentCount) : double.NaN;
        }

        /// <summary>Silence a source, or a blow, for good.</summary>
        public void Remove(Source source)
        {
            for (var i = voices.Count - 1; i >= 0; i--) if (voices[i].Source == source) voices.RemoveAt(i);
            source.Voices = 0;
            Sources.Remove(source);
            if (Blows.Remove(source)) spareBlows.Push(source);
        }

        /// <summary>Take away an object that touches nothing any more, with what is on it.</summary>
        public void Remove(TracedObject item)
        {
            Blows.FindAll(blow => blow.On == item || blow.Second == item).ForEach(Remove);
            Sources.FindAll(source => source.On == item).ForEach(Remove);
            Listeners.RemoveAll(listener => listener.On == item);
            Objects.Remove(item);
        }

        // The graph.

        void Number()
        {
            foreach (var item in Objects) item.Count = 0;
            foreach (var touching in contacts)
            {
                if (touching.Stays)
                {
                    touching.At = touching.One.ToWorld(touching.Near);
                    touching.OtherAt = touching.Other.ToWorld(touching.OtherNear);
                    touching.Normal = touching.One.Turned(touching.NormalNear);
                }
                touching.Node = touching.One.Add(touching.At, Lanes, touching);
                touching.OtherNode = touching.Other.Add(touching.OtherAt, Lanes, touching);
                touching.Node.Partner = touching.OtherNode;
                touching.OtherNode.Partner = touching.Node;
                Front(touching);
            }
            foreach (var item in Objects) item.Carries = item.Count > 1 && item.Body != null && item.Body.Carries;
            foreach (var source in Sources) source.Node = source.On.Add(source.On.ToWorld(source.Position), Lanes);
            foreach (var blow in Blows)
            {
                blow.Node = blow.On.Add(blow.On.ToWorld(blow.Position), Lanes);
                blow.SecondNode = blow.Second.Add(blow.Second.ToWorld(blow.SecondPosition), Lanes);
            }
            foreach (var listener in Listeners)
            {
                listener.Node = listener.On.Add(listener.On.ToWorld(listener.Position), Lanes);
                listener.Node.Reach = listener.Radius;
                listener.Node.Listens = true;
            }
        }

        /// <summary>The fronts of waves that begin with the size of a patch.</summary>
        static void Front(Contact touching)
        {
            if (touching.Area == 0) return;
            TracedObject one = touching.One, other = touching.Other;
            var wide = Math.Max(one.Across(touching.Normal), other.Across(touching.Normal));
            var patch = Math.Min(Math.Max(Math.Sqrt(touching.Area), touching.Area * wide), 2 * Math.Min(one.Middle, other.Middle));
            Front(touching.Node, patch);
            Front(touching.OtherNode, patch);
        }

        static void Front(Node node, double patch)
        {
            node.Run = Math.Max(patch - node.Owner.Function.Point, 0);
            if (node.Run > 0) node.Half = node.Owner.Function.Spread(node.Run) / 2;
        }

        // What contacts pass on by the impedances of their bodies.

        void PassOn()
        {
            if (Lanes == 1) return;
            foreach (var touching in contacts)
            {
                Alone(touching.Node);
                Alone(touching.OtherNode);
            }
            var isCarried = false;
            foreach (var touching in contacts) isCarried |= Drives(touching.Node) | Drives(touching.OtherNode);
            if (!isCarried) return;
            if (carrying.Length < Objects.Count) carrying = new TracedObject[Objects.Count];
            carriers = 0;
            foreach (var item in Objects)
            {
                if (!item.Carries) continue;
                carrying[carriers++] = item;
                var middle = item.ToWorld(item.Centre);
                for (var k = 0; k < item.Count; k++)
                {
                    var node = item.Nodes[k];
                    if (node.Contact == null) continue;
                    var normal = node.Contact.Normal;
                    double x = node.X - middle.X, y = node.Y - middle.Y, z = node.Z - middle.Z;
                    double a = y * normal.Z - z * normal.Y, b = z * normal.X - x * normal.Z, c = x * normal.Y - y * normal.X;
                    node.Aside = item.Body.Spring != null ? 1 : double.IsNaN(x) ? Infinite : Math.Max(a * a + b * b + c * c, 1e-12);
                }
            }
            Carry();
        }

        void Alone(Node node)
        {
            var body = node.Owner.Body;
            for (var band = 0; band < Bands; band++)
                node.Alone[band] = body == null ? 0 : body.HalfSpace == null ? body.Mobility[band] : body.At(omega[band], node.Contact.Area);
        }

        /// <summary>Whether a body drives another with what stands behind it: what is heavier in all bands passes everything anyway.</summary>
        static bool Drives(Node node)
        {
            Body body = node.Owner.Body, load = node.Partner.Owner.Body;
            var spring = node.Contact.Function.Spring;
            node.Opening = 1 / Math.Max(node.Contact.Weight, 1e-12);
            node.Give = spring == null ? 0 : 1 / spring[0];
            node.ByBodies = spring != null && body != null && load != null && (body.Kind != load.Kind || spring[0] < Infinite);
            if (!node.ByBodies || !node.Owner.Carries) return false;
            node.Carried = IsSoft(node);
            for (var band = 0; band < Bands; band++) node.Carried |= node.Alone[band] > node.Partner.Alone[band];
            return node.Carried;
        }

        static bool IsSoft(Node node) { return node.Give > 0 || node.Owner.Body.Spring != null; }

        /// <summary>The mobilities with which small bodies drive others: those of what stands behind them, through some in a row.</summary>
        void Carry()
        {
            foreach (var touching in contacts)
            {
                Array.Copy(touching.Node.Alone, touching.Node.Before, Bands);
                Array.Copy(touching.OtherNode.Alone, touching.OtherNode.Before, Bands);
            }
            for (var o = 0; o < carriers; o++)
            {
                var item = carrying[o];
                item.Due = 1;
                for (var k = 0; k < item.Count && item.Body.Spring != null; k++)
                    for (var band = 0; band < Bands; band++) item.Nodes[k].Before[band] = Infinite;
            }
            for (var link = 0; link < Chain; link++)
            {
                for (var o = 0; o < carriers; o++) if ((carrying[o].Due >> link & 1) != 0) Carry(carrying[o], 2 << link);
                for (var o = 0; o < carriers; o++)
                {
                    var item = carrying[o];
                    for (var k = 0; k < item.Count && (item.Due >> link & 1) != 0; k++) Array.Copy(item.Nodes[k].Mobility, item.Nodes[k].Before, Bands);
                }
            }
        }

        void Carry(TracedObject item, int next)
        {
            var body = item.Body;
            var flexible = body.Flexible;
            for (var band = 0; band < Bands; band++) best[band] = second[band] = Infinite;
            for (var k = 0; k < item.Count; k++)
            {
                var node = item.Nodes[k];
                if (node.Partner == null) continue;
                var beyond = node.Partner.Before;
                double opening = node.Opening, aside = node.Aside, give = node.Give;
                for (var band = 0; band < Bands; band++)
                {
                    var behind = opening * (beyond[band] + flexible[band] * aside + omega[band] * give);
                    if (behind >= second[band]) continue;
                    if (behind < best[band])
                    {
                        second[band] = best[band];
                        best[band] = behind;
                        least[band] = k;
                    }
                    else second[band] = behind;
                }
            }
            for (var k = 0; k < item.Count; k++)
            {
                var node = item.Nodes[k];
                if (node.Partner == null) continue;
                double[] alone = node.Alone, before = node.Before, now = node.Mobility;
                for (var band = 0; band < Bands; band++)
                {
                    var driving = flexible[band] * node.Aside + (least[band] == k ? second[band] : best[band]);
                    if (driving > alone[band] && body.Spring == null) driving = alone[band];
                    now[band] = driving;
                    if (driving != before[band]) node.Partner.Owner.Due |= next;
                }
            }
        }

        /// <summary>The gain of leaving through a node by the impedances of the bodies.</summary>
        double Passed(Node node, int band)
        {
            double load = node.Partner.Alone[band], driving = node.Carried ? node.Mobility[band] : node.Alone[band];
            if (!IsSoft(node)) return Math.Min(2 / (1 + driving / load), 1);
            var loss = node.Give > 0 ? node.Contact.Function.Spring[1] : node.Owner.Body.Spring[1];
            double above = Math.Max((driving + omega[band] * node.Give) / load, 2) - 1, square = loss * loss;
            return Math.Sqrt((1 + square) / (above * above + square));
        }

        /// <summary>The cost of leaving an object through a node.</summary>
        double Crossing(Node node, int lane)
        {
            if (!double.IsNaN(node.Crossing[lane])) return node.Crossing[lane];
            var touching = node.Contact;
            var function = touching.Function;
            double cost = function.Loss[lane], distance = node.Distance(node.Partner);
            if (distance > 0 || function.IsSpecial) cost += function.Decay[lane] * distance + function.Shape(distance, Value(touching, distance), 0, 0, 0);
            if (touching.Weight < 1) cost -= Math.Log(touching.Weight);
            if (node.ByBodies)
            {
                var gain = lane > 0 ? Passed(node, lane - 1) : 0;
                for (var band = 0; band < Bands && lane == 0; band++) gain = Math.Max(gain, Passed(node, band));
                cost -= Math.Log(gain);
            }
            return node.Crossing[lane] = cost;
        }

        static double Value(Contact touching, double distance)
        {
            switch (touching.Function.Variable)
            {
                case "area": return touching.Area;
                case "depth": return touching.Depth;
                case "force": return touching.Force;
                case "angle": return Math.Acos(Math.Min(Math.Abs(touching.Normal.Y), 1));
            }
            return distance;
        }

        // Best paths.

        void Propagate(Source source)
        {
            source.Fit(Listeners.Count, Lanes);
            Array.Clear(source.Gains, 0, source.Gains.Length);
            foreach (var path in source.Paths) path.Clear();
            var before = source.Before;
            source.Before = source.Now;
            source.Now = before;
            before = source.Late;
            source.Late = source.Later;
            source.Later = before;
            if (source.Sounds && Listeners.Count > 0)
            {
                Search(source, source.Signal.Lane);
                if (!Collect(source) && source.Signal.Lane > 0)
                {
                    Search(source, 0);
                    Collect(source);
                }
            }
            var rows = source.Signal.Rows.Length;
            for (var l = 0; l < Listeners.Count; l++)
                for (var row = 0; row < rows; row++)
                {
                    var mix = source.Signal.Mix[row];
                    var gain = 0.0;
                    for (var lane = 0; lane < mix.Length; lane++) gain += mix[lane] * source.Gains[l * Lanes + lane];
                    source.Now[l * rows + row] = gain * source.Amplitude * Listeners[l].Gain;
                }
            if (!source.Began) return;
            source.Began = false;
            Array.Copy(source.Now, source.Before, source.Now.Length);
            Array.Copy(source.Later, source.Late, source.Later.Length);
        }

        /// <summary>Dijkstra's algorithm; one step is through an object and over a contact.</summary>
        void Search(Source source, int lane)
        {
            foreach (var item in Objects)
                for (var k = 0; k < item.Count; k++)
                {
                    var node = item.Nodes[k];
                    node.Arrival = Limit * (1 + 1e-15);
                    node.Entry = null;
                    node.Settled = false;
                }
            var limit = Limit;
            size = 0;
            Push(0, source.Node);
            if (source.Second != null) Push(0, source.SecondNode);
            while (size > 0 && keys[0] <= limit)
            {
                var near = keys[0];
                var begin = values[0];
                Pop();
                var item = begin.Owner;
                near += item.Function.Loss[lane];
                if (begin.Settled || begin.Arrival <= near && !isSpecial) continue;
                begin.Settled = true;
                var decay = item.Function.Decay[lane];
                var isNearer = false;
                for (var k = 0; k < item.Count; k++)
                {
                    var end = item.Nodes[k];
                    if (end == begin || end.Arrival <= near) continue;
                    var distance = begin.Distance(end);
                    var far = near + decay * distance;
                    if (far >= end.Arrival) continue;
                    far += begin.Shape(end, distance);
                    if (far >= end.Arrival) continue;
                    end.Arrival = far;
                    end.Entry = begin;
                    isNearer |= end.Listens;
                    var over = end.Partner;
                    if (over == null) continue;
                    far += Crossing(end, lane);
                    if (far <= limit && (isSpecial || far + over.Owner.Function.Loss[lane] < over.Arrival)) Push(far, over);
                }
                if (!isNearer) continue;
                var dearest = 0.0;
                foreach (var listener in Listeners) dearest = Math.Max(dearest, listener.Node.Arrival);
                limit = Math.Min(limit, dearest);
            }
        }

        /// <summary>Take gains and paths to the listeners without any from the last search. Whether all have one then.</summary>
        bool Collect(Source source)
        {
            var all = true;
            for (var l = 0; l < Listeners.Count; l++)
            {
                var path = source.Paths[l];
                var node = Listeners[l].Node;
                if (path.Count > 0) continue;
                if (node.Entry == null)
                {
                    all = false;
                    continue;
                }
                Array.Clear(costs, 0, Lanes);
                var late = 0.0;
                while (true)
                {
                    var begin = node.Entry;
                    var function = node.Owner.Function;
                    double distance = begin.Distance(node), shape = begin.Shape(node, distance);
                    for (var lane = 0; lane < Lanes; lane++) costs[lane] += function.Loss[lane] + function.Decay[lane] * distance + shape;
                    late += function.Slowness * distance;
                    if (path.Count == 0 || path[path.Count - 1] != node.Owner) path.Add(node.Owner);
                    node = begin.Partner;
                    if (node == null) break;
                    for (var lane = 0; lane < Lanes; lane++) costs[lane] += Crossing(node, lane);
                    late += node.Contact.Function.Slowness * node.Distance(begin);
                }
                path.Reverse();
                for (var lane = 0; lane < Lanes; lane++) source.Gains[l * Lanes + lane] = Math.Exp(-costs[lane]);
                source.Later[l] = late * SampleRate;
            }
            return all;
        }

        void Push(double key, Node value)
        {
            if (size == keys.Length)
            {
                Array.Resize(ref keys, 2 * size);
                Array.Resize(ref values, 2 * size);
            }
            var place = size++;
            for (int above; place > 0 && keys[above = (place - 1) / 2] > key; place = above)
            {
                keys[place] = keys[above];
                values[place] = values[above];
            }
            keys[place] = key;
            values[place] = value;
        }

        void Pop()
        {
            var key = keys[--size];
            var place = 0;
            for (int below; (below = 2 * place + 1) < size; place = below)
            {
                if (below + 1 < size && keys[below + 1] < keys[below]) below++;
                if (keys[below] >= key) break;
                keys[place] = keys[below];
                values[place] = values[below];
            }
            keys[place] = key;
            values[place] = values[size];
        }

        // Samples.

        void Mix()
        {
            var window = SampleRate / 4;
            foreach (var listener in Listeners)
            {
                if (listener.Samples.Length < Count) listener.Samples = new float[Count];
                if (listener.Recent == null) listener.Recent = new float[window];
                Array.Clear(listener.Samples, 0, Count);
            }
            for (var i = voices.Count - 1; i >= 0; i--)
            {
                var voice = voices[i];
                var longest = 0.0;
                for (var l = 0; l < Listeners.Count; l++)
                {
                    Hear(voice, l);
                    longest = Math.Max(longest, voice.Source.Later[l]);
                }
                var signal = voice.Source.Signal;
                var length = signal.Rows[0].Length;
                voice.Place += Count;
                if (signal.Loops) voice.Place = voice.Place < 2 * length + longest ? voice.Place : voice.Place - length;
                voices[i] = voice;
                if (signal.Loops || voice.Place < length + longest) continue;
                voices.RemoveAt(i);
                voice.Source.Voices--;
            }
            for (var i = Blows.Count - 1; i >= 0; i--) if (Blows[i].Voices == 0) Remove(Blows[i]);
            foreach (var felt in Listeners)
            {
                var samples = felt.Samples;
                var most = (float)felt.SMax;
                for (var i = 0; i < Count; i++)
                {
                    var place = (recentPlace + i) % window;
                    double sample = Math.Max(-most, Math.Min(samples[i], most)), old = felt.Recent[place];
                    samples[i] = felt.Recent[place] = (float)sample;
                    felt.Sum += sample - old;
                    felt.Energy += sample * sample - old * old;
                }
            }
            recentPlace = (recentPlace + Count) % window;
            recentCount = Math.Min(recentCount + Count, window);
        }

        /// <summary>Add a voice to the samples of a listener; its gains go in straight lines over the step.</summary>
        void Hear(Voice voice, int number)
        {
            var source = voice.Source;
            var rows = source.Signal.Rows;
            var samples = Listeners[number].Samples;
            double late = source.Late[number], later = source.Later[number];
            for (var r = 0; r < rows.Length; r++)
            {
                var place = number * rows.Length + r;
                var gain = (float)source.Before[place];
                var slope = ((float)source.Now[place] - gain) / Math.Max(Count, 1);
                if (gain == 0 && slope == 0) continue;
                var row = rows[r];
                if (late > 0 || later > 0)
                {
                    for (var i = 0; i < Count; i++)
                    {
                        var at = voice.Place + i - late - (later - late) * i / Count;
                        var whole = (int)Math.Floor(at);
                        var share = (float)(at - whole);
                        samples[i] += (gain + slope * i) * ((1 - share) * Sample(source.Signal, row, whole) + share * Sample(source.Signal, row, whole + 1));
                    }
                    continue;
                }
                for (int i = Math.Max(-voice.Place, 0), from = Math.Max(voice.Place, 0); i < Count; from = 0)
                {
                    if (source.Signal.Loops) from %= row.Length;
                    var stop = Math.Min(Count, i + row.Length - from);
                    for (from -= i; i < stop; i++) samples[i] += (gain + slope * i) * row[from + i];
                    if (!source.Signal.Loops) break;
                }
            }
        }

        static float Sample(Signal signal, float[] row, int place)
        {
            if (place < 0) return 0;
            return signal.Loops ? row[place % row.Length] : place < row.Length ? row[place] : 0;
        }

        // The file.

        /// <summary>A tracer of the tables in NAME.tracer.json.</summary>
        public static Tracer Read(string json)
        {
            var file = (Dictionary<string, object>)Json.Read(json);
            if ((string)file["format"] != "haptic-tracer" || (double)file["version"] != 1) throw new FormatException("no tables of a haptic tracer 1");
            var tracer = new Tracer(Whole(file["lanes"]), Whole(file["sample_rate"]));
            var frequencies = Numbers(file["frequencies"]);
            for (var band = 0; band < Bands; band++) tracer.omega[band] = 2 * Math.PI * frequencies[band];
            var grid = Numbers(file["grid"]);
            var functions = List(file["functions"]).ConvertAll(row => ReadFunction(row, grid));
            var signals = List(file["signals"]).ConvertAll(ReadSignal);
            var impacts = List(file["impacts"]).ConvertAll(row => ReadImpact(row, signals));
            tracer.Between = Table(file["between"], functions);
            tracer.Impacts = Table(file["blows"], impacts);
            foreach (Dictionary<string, object> row in List(file["objects"]))
            {
                var pose = Numbers(row["pose"]);
                var item = new TracedObject { Name = (string)row["name"], Class = Whole(row["class"]), Mass = (double)row["mass"], Function = functions[Whole(row["function"])] };
                item.Move(pose[0], pose[1], pose[2], pose[3], pose[4], pose[5], pose[6]);
                if (row.ContainsKey("centre"))
                {
                    item.Centre = Vector(row["centre"]);
                    item.Size = Vector(row["size"]);
                }
                if (row.ContainsKey("body"))
                {
                    var body = (Dictionary<string, object>)row["body"];
                    double[] bending = Numbers(Get(body, "bending")), spring = Numbers(Get(body, "spring"));
                    item.Body = new Body { Kind = Whole(body["kind"]), Mobility = Array.ConvertAll(Numbers(body["impedance"]), value => 1 / value), HalfSpace = Numbers(Get(body, "half_space")), Spring = spring };
                    if (spring != null) item.Body.Flexible = Array.ConvertAll(tracer.omega, omega => omega / (2 * spring[0]));
                    else if (bending != null) item.Body.Flexible = Array.ConvertAll(bending, value => 1 / value);
                }
                tracer.Objects.Add(item);
            }
            foreach (Dictionary<string, object> row in List(file["contacts"]))
            {
                List<object> objects = List(row["objects"]), places = List(row["positions"]);
                var added = new Contact { One = tracer.Objects[Whole(objects[0])], Other = tracer.Objects[Whole(objects[1])], Near = Vector(places[0]), OtherNear = Vector(places[1]), NormalNear = Vector(row["normal"]), Area = (double)row["area"], Depth = (double)row["depth"], Weight = (double)row["weight"], Function = functions[Whole(row["function"])], Stays = true };
                tracer.contacts.Add(added);
                added.One.Joined.Add(added.Other);
                added.Other.Joined.Add(added.One);
            }
            foreach (Dictionary<string, object> row in List(file["sources"]))
                tracer.Sources.Add(new Source { Name = (string)row["name"], On = tracer.Objects[Whole(row["object"])], Position = Vector(row["position"]), Amplitude = (double)row["amplitude"], Once = (bool)row["once"], Signal = signals[Whole(row["signal"])] });
            foreach (Dictionary<string, object> row in List(file["listeners"]))
                tracer.Listeners.Add(new Listener { Name = (string)row["name"], BodyPart = (string)row["body_part"], On = tracer.Objects[Whole(row["object"])], Position = Vector(row["position"]), Radius = (double)row["radius"], Gain = (double)row["gain"], SMax = (double)row["s_max"] });
            return tracer;
        }

        static Function ReadFunction(object form, double[] grid)
        {
            var row = (Dictionary<string, object>)form;
            var function = new Function { Loss = Numbers(row["loss"]), Decay = Numbers(row["decay"]), Grid = grid, Costs = Numbers(Get(row, "costs")), Spring = Numbers(Get(row, "spring")), Variable = (string)Get(row, "over") };
            if (row.ContainsKey("range")) function.Range = (double)row["range"];
            if (row.ContainsKey("slowness")) function.Slowness = (double)row["slowness"];
            var law = Numbers(Get(row, "spreading"));
            if (law == null) return function;
            function.Exponent = law[0];
            function.Reference = law[1];
            function.Extent = law[2];
            function.Width = law[3];
            function.Over = law[4];
            function.Point = law[5];
            return function;
        }

        static Signal ReadSignal(object form)
        {
            var row = (Dictionary<string, object>)form;
            var peak = (double)row["peak"];
            return new Signal { Lane = Whole(row["lane"]), Loops = (bool)row["loops"], Mix = List(row["mix"]).ConvertAll(Numbers).ToArray(), Power = List(row["power"]).ConvertAll(Numbers).ToArray(), Rows = List(row["rows"]).ConvertAll(text => Samples((string)text, peak)).ToArray() };
        }

        static float[] Samples(string text, double peak)
        {
            var bytes = Convert.FromBase64String(text);
            var integers = new short[bytes.Length / 2];
            Buffer.BlockCopy(bytes, 0, integers, 0, 2 * integers.Length);
            return Array.ConvertAll(integers, value => (float)(value * peak / 32767));
        }

        static Impact ReadImpact(object form, List<Signal> signals)
        {
            var row = (Dictionary<string, object>)form;
            var gain = Numbers(row["gain"]);
            return new Impact { LeastEnergy = (double)row["least_energy"], FullEnergy = (double)row["full_energy"], WeakGain = gain[0], FullGain = gain[1], Signals = List(row["signals"]).ConvertAll(number => signals[Whole(number)]).ToArray() };
        }

        static T[][] Table<T>(object rows, List<T> items) where T : class
        {
            return List(rows).ConvertAll(row => List(row).ConvertAll(number => number == null ? null : items[Whole(number)]).ToArray()).ToArray();
        }

        static object Get(Dictionary<string, object> form, string key)
        {
            object value;
            return form.TryGetValue(key, out value) ? value : null;
        }

        static List<object> List(object value) { return (List<object>)value; }
        static int Whole(object value) { return (int)(double)value; }
        static double[] Numbers(object value) { return value == null ? null : List(value).ConvertAll(item => item == null ? Infinite : (double)item).ToArray(); }
        static Vector Vector(object value)
        {
            var numbers = Numbers(value);
            return new Vector(numbers[0], numbers[1], numbers[2]);
        }
    }

    /// <summary>JSON as dictionaries, lists, strings, doubles, booleans and null.</summary>
    static class Json
    {
        public static object Read(string text)
        {
            var place = 0;
            return Read(text, ref place);
        }

        static object Read(string text, ref int place)
        {
            Skip(text, ref place);
            var start = place;
            switch (text[place++])
            {
                case '{':
                    var members = new Dictionary<string, object>();
                    while (More(text, ref place, '}'))
                    {
                        var key = (string)Read(text, ref place);
                        Skip(text, ref place);
                        place++; // the colon
                        members[key] = Read(text, ref place);
                    }
                    return members;
                case '[':
                    var items = new List<object>();
                    while (More(text, ref place, ']')) items.Add(Read(text, ref place));
                    return items;
                case '"':
                    while (text[place] != '"') place += text[place] == '\\' ? 2 : 1;
                    return Regex.Unescape(text.Substring(start + 1, place++ - start - 1));
                case 't': place += 3; return true;
                case 'f': place += 4; return false;
                case 'n': place += 3; return null;
            }
            while (place < text.Length && "+-.eE0123456789".IndexOf(text[place]) >= 0) place++;
            return double.Parse(text.Substring(start, place - start), CultureInfo.InvariantCulture);
        }

        static bool More(string text, ref int place, char close)
        {
            Skip(text, ref place);
            if (text[place] == ',') { place++; Skip(text, ref place); }
            if (text[place] != close) return true;
            place++;
            return false;
        }

        static void Skip(string text, ref int place) { while (char.IsWhiteSpace(text[place])) place++; }
    }
}
